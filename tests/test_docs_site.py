"""The site is whole: pages made of the code, links that lead somewhere, equations."""

import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
import yaml
from axe import violations
from browsed import Page

ROOT = Path(__file__).parents[1]
MODELS = ("plants.leadscrew.axis", "controllers.ball_screw.mc_ppc")
SITE = str(ROOT / "docs" / "site")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source of the site with two models' pages; a dead link would end it."""
    folder = tmp_path_factory.mktemp("site") / "source"
    code = (
        "import sys; from pathlib import Path; import make;"
        "make.gather(Path(sys.argv[1]), sys.argv[2:])"
    )
    command = [sys.executable, "-c", code, str(folder), *MODELS]
    environment = {"PYTHONPATH": f"{SITE}:{ROOT}"}
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def built(source: Path) -> Path:
    """The site with two models' pages, built strictly."""
    folder = source.parent
    for name in ("ball_screw", "gantry"):  # tests/orchestrator/playground looks at them
        (source / "playground").mkdir(exist_ok=True)
        (source / "playground" / f"{name}.html").write_text("<title>made later</title>")
    text = (ROOT / "mkdocs.yml").read_text()
    for before, after in (
        ("docs_dir: dist/site-source", "docs_dir: source"),
        ("site_dir: dist/site", "site_dir: site"),
        ("paths: [.]", f"paths: [{ROOT}]"),
    ):
        assert before in text
        text = text.replace(before, after)
    (folder / "mkdocs.yml").write_text(text)
    command = [sys.executable, "-m", "zensical", "build", "--strict"]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "site"


def _complaints(driver: Any, pages: Iterable[Path]) -> list[str]:
    """Return what axe finds in the pages, on light and on dark paper."""
    shown, found = Page(driver, ""), []
    for file in pages:
        driver.get(file.as_uri())
        for scheme in ("default", "slate"):
            driver.execute_script(
                "document.body.setAttribute('data-md-color-scheme', arguments[0])",
                scheme,
            )
            told = violations(shown, "light")
            found += [f"{file.name}, {scheme}: {text}" for text in told]
    return found


def test_axe_finds_nothing_in_pages_of_the_site(built: Path, driver: Any) -> None:
    pages = ("add-a-drive", "reference/plants.leadscrew.axis", "reference/python")
    assert _complaints(driver, [built / f"{name}.html" for name in pages]) == []


def _pages(entries: list[object]) -> list[str]:
    found: list[str] = []
    for entry in entries:
        assert isinstance(entry, dict)
        for page in entry.values():
            found += _pages(page) if isinstance(page, list) else [page]
    return found


def test_every_page_can_be_reached_and_every_entry_is_a_page(source: Path) -> None:
    nav = _pages(yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"])
    assert [page for page in nav if not (source / page).is_file()] == []
    written = {p.relative_to(ROOT / "docs").as_posix() for p in ROOT.glob("docs/*.md")}
    written |= {f"studies/{p.name}" for p in ROOT.glob("docs/studies/*.md")}
    assert sorted(written - set(nav)) == []


def test_a_page_of_a_model_has_its_equations_and_every_variable(source: Path) -> None:
    page = (source / "reference" / "plants.leadscrew.axis.md").read_text()
    assert page.count("<math") == 3
    assert '<mo stretchy="false">≤</mo>' in page
    for name in ("`u`", "`omega`", "`C_sd`", "`state.theta`", "<svg"):
        assert name in page


def test_keys_and_verbs_are_those_of_the_code(source: Path) -> None:
    keys = (source / "reference" / "keys.md").read_text()
    for key in ("latency", "answer_within", "expect_like", "tolerances", "at_end"):
        assert f"| `{key}` |" in keys
    assert not re.search(r"<function|PlainValidator|typing", keys)
    verbs = (source / "reference" / "verbs.md").read_text()
    assert "## second-opinion" in verbs
    assert "| `--until-breaks` | KEY |" in verbs


def test_the_whole_site_builds_and_no_link_is_dead_and_axe_finds_nothing(
    request: pytest.FixtureRequest,
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form builds the site")
    driver = request.getfixturevalue("driver")
    done = subprocess.run(
        [sys.executable, "docs/site/make.py"],
        cwd=ROOT,
        env={"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    site = ROOT / "dist" / "site"
    pages = sorted(set(site.rglob("*.html")) - {site / "404.html"})
    assert len(pages) > 150
    assert _complaints(driver, pages) == []
