"""``make docs``: the pages of docs/ and those made of the code, as one site.

The source of the site is gathered in ``dist/site-source`` and built by Zensical into
``dist/site``, which needs no network.  A link that leads nowhere ends it with 1.
"""

import importlib
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from keys import keys_page
from pages import model_page, models_page, verbs_page

from orchestrator.cli.fmus import model_modules
from orchestrator.playground import page as played
from orchestrator.playground.compiled import Playable
from orchestrator.playground.schema import pages

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "dist" / "site-source"
SITE = ROOT / "dist" / "site"
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)#\s]+)(#[^)\s]*)?\)")


PLAYED = {f"playground/{name}.html": spec for name, spec in pages().items()}


def gather(folder: Path, modules: Iterable[str]) -> None:
    """Write the source of the site, with these models' pages, into an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    docs = ROOT / "docs"
    for file in sorted(docs.rglob("*")):
        place = file.relative_to(docs)
        if place.parts[0] in ("site", "examples") or not file.is_file():
            continue
        if file.suffix == ".md":
            _write(folder / place, _links(file, docs))
        elif file.suffix in (".png", ".svg"):
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, folder / place)
    _write(folder / "index.md", _links(ROOT / "README.md", docs))
    for name in ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"):
        _write(folder / name.lower(), _links(ROOT / name, docs))
    _write(folder / "decisions" / "index.md", _decisions(docs / "decisions"))
    (folder / "reference").mkdir()
    for name in ("extra.css", "access.js"):
        shutil.copy(docs / "site" / name, folder / name)
    shutil.copy(docs / "site" / "python.md", folder / "reference" / "python.md")
    _write(folder / "reference" / "verbs.md", verbs_page())
    _write(folder / "reference" / "keys.md", keys_page())
    firsts = {name: _first_line(name) for name in modules}
    _write(folder / "reference" / "index.md", models_page(firsts))
    for name in firsts:
        _write(folder / "reference" / f"{name}.md", model_page(name))


def play(folder: Path) -> None:
    """Write the pages that run in the browser."""
    for place, spec in PLAYED.items():
        _write(folder / place, played.page(Playable(spec), "../playground.html"))


def _write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def _first_line(module: str) -> str:
    text = importlib.import_module(module).__doc__ or ""
    return text.strip().partition("\n")[0].rstrip(".")


def _decisions(folder: Path) -> str:
    rows = [
        f"* [{file.read_text(encoding='utf-8').partition(chr(10))[0][2:]}]({file.name})"
        for file in sorted(folder.glob("[0-9]*.md"))
    ]
    return "\n".join(["# Decisions\n", *rows, ""])


def _links(file: Path, docs: Path) -> str:
    """Return a page with links that hold in the site; what is no page is only named."""

    def link(match: re.Match[str]) -> str:
        before, target, part = match[1], match[2], match[3] or ""
        if "://" in target or target.startswith("mailto:") or target in PLAYED:
            return match[0]
        there = (file.parent / target).resolve()
        if not there.exists():
            raise SystemExit(f"{file}: there is no {target}")
        page = _target(file, there, docs)
        return f"{before}{page}{part})" if page else before[1:-2]

    return LINK.sub(link, file.read_text(encoding="utf-8"))


def _target(file: Path, there: Path, docs: Path) -> str | None:
    ups = (
        "" if file.parent == ROOT else "../" * len(file.parent.relative_to(docs).parts)
    )
    if there == docs / "decisions":
        return f"{ups}decisions/index.md"
    if there.is_relative_to(docs) and there.suffix in (".md", ".png", ".svg"):
        return ups + there.relative_to(docs).as_posix()
    if there.parent == ROOT and there.suffix == ".md":
        name = "index" if there.stem == "README" else there.stem.lower()
        return f"{ups}{name}.md"
    return None  # a folder or a file of the source


def missing(site: Path = SITE) -> Iterator[str]:
    """Yield the links between pages of the built site that lead nowhere."""
    for page in sorted(set(site.rglob("*.html")) - {site / "404.html"}):
        for target in re.findall(r'(?:href|src)="([^"#?]+)', page.read_text()):
            if ":" in target or target.startswith("//"):
                continue
            there = (page.parent / target).resolve()
            if not (there.is_file() or (there / "index.html").is_file()):
                yield f"{page.relative_to(site)}: {target}"


def main() -> int:
    """Build the site; 1 if a link leads nowhere."""
    gather(SOURCE, model_modules())
    play(SOURCE)
    built = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--clean", "--strict"],
        cwd=ROOT,
        check=False,
    )
    if built.returncode:
        return built.returncode
    lost = list(missing())
    for line in lost:
        print(f"leads nowhere: {line}", file=sys.stderr)
    pages = len(list(SITE.rglob("*.html")))
    print(f"{pages} pages in {SITE.relative_to(ROOT)}")
    return 1 if lost else 0


if __name__ == "__main__":
    raise SystemExit(main())
