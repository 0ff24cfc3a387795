"""Mappings of single values: of Booleans, integers and items of enumerations.

A parameter is looked up when it is read; a signal gets a table in the map of the input
that it leads to.  What is not listed is refused, there at once, here at its instant.
"""

from dataclasses import replace

from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.records import Given, Looked
from orchestrator.fmu.description import FmuVariable

_TRUTH = {"true": "1", "1": "1", "false": "0", "0": "0"}


def looked_up(given: Given, how: Looked) -> Given:
    """Return a parameter whose values are those that a mapping gives them.

    Raises:
        ScenarioError: it is of another type, or a value is not listed.
    """
    if given.type != how.type and not (
        how.type == "Integer" and given.type.lstrip("U").startswith("Int")
    ):
        raise ScenarioError(
            f"{given.name} is {given.type}, and its mapping is of {how.type} values"
        )
    becomes = {_word(how.type, source): target for source, target in how.pairs}
    words = []
    for word in given.words:
        found = becomes.get(_word(how.type, word))
        if found is None:
            listed = ", ".join(source for source, _ in how.pairs)
            raise ScenarioError(
                f"{given.name} is {word}, and its mapping lists {listed} only"
            )
        words.append(found)
    return replace(given, words=tuple(words))


def table_of(
    how: Looked, source: FmuVariable, sink: FmuVariable
) -> tuple[tuple[int, int], ...]:
    """Return the table by which a signal is looked up on its way.

    Raises:
        ScenarioError: a value is none of the variables' types.
    """
    return tuple(
        (_held(how, one, source), _held(how, to, sink)) for one, to in how.pairs
    )


def words_of(
    source: FmuVariable, sink: FmuVariable, pairs: tuple[tuple[int, int], ...]
) -> Looked:
    """Return how a table is written in a package.

    Raises:
        ScenarioError: the two ends are not of one type, as SSP wants them.
    """
    types = {_type(source), _type(sink)}
    if len(types) > 1:
        raise ScenarioError(
            f"is looked up from {source.kind} to {sink.kind}, and SSP maps values of "
            f"one type to values of the same; let a component do it"
        )
    said = tuple((_said(source, one), _said(sink, other)) for one, other in pairs)
    return Looked(types.pop(), said)


def _type(variable: FmuVariable) -> str:
    if variable.declared.items:
        return "Enumeration"
    return "Boolean" if variable.sort == "boolean" else "Integer"


def _word(type_: str, word: str) -> str:
    if type_ == "Boolean":
        return _TRUTH.get(word.strip().lower(), word)
    return str(int(word)) if type_ == "Integer" and _is_whole(word) else word


def _held(how: Looked, word: str, variable: FmuVariable) -> int:
    if how.type != _type(variable):
        raise ScenarioError(
            f"maps {how.type} values, and {variable.name} is {variable.kind}"
        )
    if how.type == "Enumeration":
        for item in variable.declared.items:
            if item.name == word:
                return item.value
        known = ", ".join(item.name for item in variable.declared.items)
        raise ScenarioError(f"{word!r} is no item of {variable.name}; it has {known}")
    bare = _word(how.type, word)
    if not _is_whole(bare):
        raise ScenarioError(f"{word!r} is no {how.type}")
    return int(bare)


def _said(variable: FmuVariable, value: int) -> str:
    for item in variable.declared.items:
        if item.value == value:
            return item.name
    return str(bool(value)).lower() if variable.sort == "boolean" else str(value)


def _is_whole(word: str) -> bool:
    return word.strip().lstrip("+-").isdecimal()
