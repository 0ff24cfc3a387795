"""Every block of code and every command of the docs is tried, or a reason is given.

``tests/data/blocks.toml`` says of each block what is done with it; a block that is
added without a line there fails, and so does a command whose verb or option is none.
``pytest -rP tests/test_docs_blocks.py -k counted`` prints how many there are.
"""

import re
import shlex
import shutil
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from printed import typed

from orchestrator.bands.spread import read_bands
from orchestrator.cli import app
from orchestrator.drawings.registry import read_registry
from orchestrator.reproduction.published import Statement
from orchestrator.reproduction.reference import FigureSpec, read_reference
from orchestrator.scenario.reading import load_scenario
from orchestrator.supplied import PROJECT

ROOT = Path(__file__).parents[1]
TABLE = tomllib.loads((ROOT / "tests/data/blocks.toml").read_text())
BLOCK = re.compile(r"^```([^\n]*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"`(feeddrive [a-z][^`]*)`")
PAGES = {
    "README": ROOT / "README.md",
    "CONTRIBUTING": ROOT / "CONTRIBUTING.md",
    "site/python": ROOT / "docs" / "site" / "python.md",
    **{f.stem: f for f in sorted((ROOT / "docs").glob("*.md"))},
    **{f"studies/{f.stem}": f for f in sorted((ROOT / "docs/studies").glob("*.md"))},
}
ROW = {
    "id": "a",
    "where": "1",
    "obtained": "plot",
    "published": 1.0,
    "class": "derived",
}


def blocks() -> Iterator[tuple[str, int, str]]:
    """Yield page, place and text of every block."""
    for name, file in PAGES.items():
        found = BLOCK.findall(file.read_text(encoding="utf-8"))
        yield from ((name, i, text) for i, (_, text) in enumerate(found))


TEXTS = {(name, i): text for name, i, text in blocks()}
DONE: list[tuple[str, int, dict[str, Any]]] = [
    (name, i, entry)
    for name, entries in TABLE.items()
    for i, entry in enumerate(entries)
]


def of(how: str) -> list[Any]:
    return [
        pytest.param(TEXTS.get((name, i), ""), entry, id=f"{name}-{i}")
        for name, i, entry in DONE
        if how in entry
    ]


def commands(text: str) -> list[str]:
    """Return the commands in a block, each on a line of its own."""
    lines = (line.removeprefix("$ ") for line in text.splitlines())
    return [line for line in lines if line.startswith("feeddrive ")]


def test_every_block_has_its_line_and_is_counted() -> None:
    listed = {(name, i) for name, i, _ in DONE}
    new = sorted(TEXTS.keys() - listed)
    assert not new, f"say in tests/data/blocks.toml what is done with {new}"
    assert listed == TEXTS.keys()
    count = Counter(next(iter(entry)) for _, _, entry in DONE)
    shown = count.pop("shown")
    print(
        f"{len(DONE)} blocks, {len(DONE) - shown} tried: {dict(count)}; {shown} shown"
    )
    for name, i, entry in DONE:
        if "shown" in entry:
            print(f"  {name} {i}: {entry['shown']}")


@pytest.mark.parametrize(("text", "entry"), of("run"))
def test_the_test_that_runs_a_block_is_there(text: str, entry: dict[str, str]) -> None:
    file, _, function = entry["run"].partition("::")
    assert f"def {function}(" in (ROOT / file).read_text()


@pytest.mark.parametrize(("text", "entry"), of("scenario"))
def test_a_piece_of_a_scenario_loads(
    text: str, entry: dict[str, str], tmp_path: Path
) -> None:
    base = entry["scenario"]
    if "\n" in base:
        (tmp_path / "base.toml").write_text(f'stop = "1"\n{base}')
        text = f'base = "base.toml"\n{text}'
    elif base and "base =" not in text:
        text = f'base = "{base}"\n{text}'
    shutil.copytree(PROJECT, tmp_path / "drive")
    file = tmp_path / "drive" / "tests" / "piece.toml"
    for extra in tmp_path.glob("*.toml"):
        shutil.copy(extra, file.parent)
    file.write_text(text)
    written = tomllib.loads(text)
    spec = load_scenario(file).spec
    assert set(written.get("components", {})) <= set(spec.components)
    assert set(written.get("metrics", {})) <= set(spec.metrics)


@pytest.mark.parametrize(("text", "entry"), of("read"))
def test_what_is_no_scenario_is_read_by_its_reader(
    text: str, entry: dict[str, str], tmp_path: Path
) -> None:
    written = tomllib.loads(text) if entry["read"] != "statements" else {}
    if entry["read"] == "figures":
        (tmp_path / "figures.toml").write_text(text)
        assert read_registry(tmp_path).figures.keys() == written.keys()
    elif entry["read"] == "bands":
        (tmp_path / "bands.toml").write_text(text)
        assert read_bands(tmp_path).keys() == written.keys()
    elif entry["read"] == "reference":
        (tmp_path / "reference.toml").write_text(text)
        assert read_reference(tmp_path / "reference.toml").figures
    elif entry["read"] == "row":
        of_run = {} if "formula" in written else {"scenario": "a", "metric": "b.peak"}
        assert FigureSpec.model_validate({**ROW, **of_run, **written})
    elif entry["read"] == "statements":
        for line in text.splitlines():
            (value,) = tomllib.loads(line).values()
            assert value == "drawn" or Statement.model_validate(value)
    else:
        assert written


@pytest.mark.parametrize(("text", "entry"), of("part_of"))
def test_what_the_docs_quote_stands_in_the_file(
    text: str, entry: dict[str, str]
) -> None:
    file = ROOT / entry["part_of"]
    if file.suffix == ".toml":
        there, said = tomllib.loads(file.read_text()), tomllib.loads(text)
        assert {key: there[key] for key in said} == said
        return
    squeezed = re.sub(r"MODELS / \"", '"models/', file.read_text())
    for function in re.split(r"\n\n\n", text.strip())[1:]:
        assert function in squeezed


@pytest.mark.parametrize(("text", "entry"), of("typed"))
def test_the_commands_of_a_block_run(
    text: str, entry: dict[str, Any], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form runs them")
    lines = commands(text)
    for theirs, ours in entry["given"].items():
        lines = [line.replace(theirs, ours) for line in lines]
    assert lines
    for line in [*entry["typed"], *lines]:
        typed(line.partition(" # ")[0], tmp_path)


def said() -> list[tuple[str, str]]:
    """Return every command that a page has, in blocks or in its text."""
    found = [(n, line) for (n, _), text in TEXTS.items() for line in commands(text)]
    for name, file in PAGES.items():
        text = BLOCK.sub("", file.read_text(encoding="utf-8"))
        found += [(name, line) for line in INLINE.findall(text)]
    return found


def test_every_command_of_the_docs_has_a_verb_and_options_that_exist() -> None:
    verbs = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    wrong, seen = [], 0
    for page, line in said():
        line = line.partition(" # ")[0].replace("`", "").replace("...", "")
        words = shlex.split(line.replace("'", "").replace('"', ""))
        verb = verbs.get(words[1])
        if verb is None:
            wrong.append(f"{page}: {line}: there is no verb {words[1]}")
            continue
        known = {o for p in verb.params for o in (*p.opts, *p.secondary_opts)}
        options = [w.partition("=")[0] for w in words[2:] if re.match(r"--?[a-z]", w)]
        unknown = [o for o in options if o not in known | {"--help"}]
        wrong += [f"{page}: {line}: {o} is no option" for o in unknown]
        seen += 1
    assert wrong == []
    print(f"{seen} commands: verbs and options exist")
    assert seen > 80


def test_the_rows_of_a_run_are_read_as_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    typed("feeddrive run ball_screw_pole_placement/mc_ppc_track_500", tmp_path)
    names: dict[str, Any] = {}
    exec(TEXTS["scenarios", 6], names)
    assert len(names["rows"]) == 15_013


def test_the_python_of_the_reference_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(TEXTS["site/python", 0], names)
    assert len(names["x_2"].values) == 15_013
