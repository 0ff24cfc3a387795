"""Arithmetic in named numbers, for figures made of other figures."""

import ast
import operator
from collections.abc import Callable, Mapping

from orchestrator.errors import ScenarioError, did_you_mean

_OPERATORS: dict[type[ast.AST], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}


def evaluate_formula(formula: str, values: Mapping[str, float]) -> float:
    """Return the value of an arithmetic formula in named numbers.

    Raises:
        ScenarioError: anything but numbers, names and + - * / ** ( ), or 1/0.
    """

    def value(node: ast.AST) -> float:
        match node:
            case ast.Constant(value=int() | float() as number):
                return float(number)
            case ast.Name(id=name) if name in values:
                return values[name]
            case ast.Name(id=name):
                raise ScenarioError(f"{formula}: {name}? {did_you_mean(name, values)}")
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
                return _OPERATORS[type(op)](value(left), value(right))
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return -value(operand)
        raise ScenarioError(f"{formula}: write numbers, names and + - * / ** ( ) only")

    try:
        return value(ast.parse(formula, mode="eval").body)
    except (SyntaxError, ArithmeticError) as error:
        raise ScenarioError(f"{formula}: {error}") from None
