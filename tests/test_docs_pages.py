"""What the pages say to type works."""

import shutil
from pathlib import Path

import pytest
from printed import blocks, typed

ROOT = Path(__file__).parents[1]
PAGES = {
    "what-margin-is-left": "margin",
    "tune": "margin",
    "measured-data": "measured_data",
    "swap-my-plant": "",
    "why-it-differs": "",
    "add-a-drive": "",
}
PLAIN = {"what-margin-is-left": 1, "measured-data": 2, "add-a-drive": 2}  # commands


def page(name: str) -> str:
    return (ROOT / "docs" / f"{name}.md").read_text()


def example(name: str, folder: Path) -> None:
    if PAGES[name]:
        source = ROOT / "docs" / "examples" / PAGES[name]
        shutil.copytree(source, folder, dirs_exist_ok=True)


@pytest.mark.parametrize("name", PAGES)
def test_the_commands_of_a_page_run_one_after_the_other(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    lines = [c for b in blocks(page(name), "bash") for c in b.splitlines()]
    if not request.config.getoption("--every-form"):
        lines = lines[: PLAIN.get(name, 0)]
    example(name, tmp_path)
    for line in lines:
        typed(line, tmp_path)


def test_the_python_of_what_margin_is_left_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form measures once more")
    monkeypatch.chdir(tmp_path)
    example("what-margin-is-left", tmp_path)
    (session,) = blocks(page("what-margin-is-left"), "python")
    exec(session, {})
