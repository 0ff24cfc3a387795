"""Arithmetic in named numbers, for figures made of other figures."""

import ast
import math
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
        ScenarioError: anything but numbers, names, + - * / ** ( ) and log10( ), or 1/0.
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
            case ast.Call(func=ast.Name(id="log10"), args=[argument], keywords=[]):
                return math.log10(value(argument))
        raise ScenarioError(
            f"{formula}: write numbers, names, + - * / ** ( ) and log10( ) only"
        )

    try:
        return value(ast.parse(formula, mode="eval").body)
    except (SyntaxError, ArithmeticError, ValueError) as error:
        raise ScenarioError(f"{formula}: {error}") from None
