"""The house's own rules, walked over every file of it."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
MODELS = ("plants", "controllers")
FLAT = 12  # files of a ground floor
MOST = 350  # lines; a file that is longer holds two things
SOURCES = {".py", ".c", ".h", ".css", ".js", ".md", ".toml"}
NOT_OURS = ROOT / "fmus" / "native"  # the FMI headers stand there as published


def test_no_file_is_longer_than_a_thing_takes() -> None:
    rooms = ("controllers", "docs", "fmus", "orchestrator", "plants", "tests")
    long = {
        str(file.relative_to(ROOT)): lines
        for room in rooms
        for file in (ROOT / room).rglob("*")
        if file.suffix in SOURCES and not _as_published(file)
        if (lines := len(file.read_text(encoding="utf-8").splitlines())) > MOST
    }
    assert long == {}


def _as_published(file: Path) -> bool:
    header = file.parent == NOT_OURS and file.match("fmi[23]*.h")
    library = {"vendor", "elkjs"} & set(file.parts)  # of others, with their licence
    figures = file.name in ("reference.toml", "figures.toml")
    return header or bool(library) or figures


def test_ground_floors_stay_small() -> None:
    """What lies flat in a package is what everybody uses; the rest has a room."""
    flat = {p: len(list((ROOT / p).glob("*.py"))) for p in (*MODELS, "orchestrator")}
    assert flat["orchestrator"] <= FLAT
    assert sum(flat[p] for p in MODELS) <= FLAT


def test_decisions_have_a_number_each() -> None:
    files = sorted((ROOT / "docs" / "decisions").glob("*.md"))
    numbers = [file.name[:4] for file in files]
    assert len(set(numbers)) == len(numbers)
    for file in files:
        assert file.read_text(encoding="utf-8").startswith(f"# {file.name[:4]} ")
