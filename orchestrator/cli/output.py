"""What all verbs share: where output goes, and how errors end."""

import functools
import inspect
import json
import logging
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from math import isfinite
from pathlib import Path
from textwrap import fill
from time import perf_counter
from traceback import extract_tb
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec

import typer

from fmus.allowed import only_project
from orchestrator.errors import shown

if TYPE_CHECKING:
    from rich.console import Console

TRACEBACK = "FEEDDRIVE_TRACEBACK"
MANY = 1000  # rows of a table that is still laid out for the terminal
P = ParamSpec("P")
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", help="execute Python, and open sources of packages, from anywhere"
    ),
]
Progress = Callable[[Fraction], None]


def command(function: Callable[P, None]) -> Callable[P, None]:
    """Let every refusal end in one paragraph on stderr and an exit code.

    With ``--json`` stdout gets {"error": "..."} besides, and where rows are there
    "result", the folder of the run.
    """

    @functools.wraps(function)
    def guarded(*args: P.args, **kwargs: P.kwargs) -> None:
        from fmus.build import BuildError
        from fmus.compile import CompileError
        from fmus.units import UnitError
        from orchestrator.errors import FeedDriveError

        def fail(message: str, code: int, folder: Path | None = None) -> None:
            if kwargs.get("json"):
                rows = {"result": str(folder)} if folder else {}
                with _stdout_closed_when_full():
                    print_json({"error": message, **rows})
            typer.secho("error: ", fg="red", bold=True, nl=False, err=True)
            echo(message, err=True)
            raise typer.Exit(code)

        trusting = bool(kwargs.pop("trust", False))
        try:
            _refuse_names([Path.cwd(), *args, *kwargs.values()])
            with only_project(not trusting):
                function(*args, **kwargs)
        except FeedDriveError as error:
            fail(str(error), error.exit_code, error.folder)
        except (BuildError, CompileError, UnitError) as error:
            fail(str(error), 2)
        except BrokenPipeError:  # the reader, say `head`, has seen enough
            _close_stdout()
            raise typer.Exit(0) from None
        except OSError as error:
            reason = error.strerror or str(error)
            if error.filename is None and _was_printing(error):
                _close_stdout()
                reason = f"standard output: {reason}"
            fail(f"{error.filename}: {reason}" if error.filename else reason, 1)
        except KeyboardInterrupt:
            fail("interrupted", 130)
        except (typer.Exit, typer.Abort):
            raise
        except Exception as error:
            if os.environ.get(TRACEBACK):
                raise
            fault = f"{type(error).__name__}: {error}"
            fail(f"a fault in feeddrive: {fault}; {TRACEBACK}=1 shows where", 1)

    return guarded


def executing(function: Callable[P, None]) -> Callable[P, None]:
    """Make a ``command`` that may execute Python: with ``--trust``, of anybody."""
    guarded: Any = command(function)
    signature = inspect.signature(function)
    trust = inspect.Parameter(
        "trust", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Trust
    )
    guarded.__signature__ = signature.replace(
        parameters=[*signature.parameters.values(), trust]
    )
    guarded.__annotations__ = {**function.__annotations__, "trust": Trust}
    executed: Callable[P, None] = guarded
    return executed


def echo(text: str, *, err: bool = False) -> None:
    """Print a text; what an FMU or a file put into it to steer a terminal is shown."""
    typer.echo(shown(text), err=err)


def _was_printing(error: OSError) -> bool:
    """Tell whether what failed was a print, which names no file."""
    names = {frame.name for frame in extract_tb(error.__traceback__)}
    return bool(names & {"echo", "print_table"})


def _refuse_names(given: Iterable[object]) -> None:
    """Refuse names that could not be written down: those that are no UTF-8."""
    from orchestrator.errors import ScenarioError

    for value in given:
        if isinstance(value, list):
            _refuse_names(value)
        elif isinstance(value, str | Path):
            try:
                str(value).encode()
            except UnicodeEncodeError:
                raise ScenarioError(
                    f"{value}: this name is no UTF-8, in which files of runs are "
                    f"written; rename it"
                ) from None


@contextmanager
def _stdout_closed_when_full() -> Iterator[None]:
    try:
        yield
    except OSError:
        _close_stdout()


def _close_stdout() -> None:
    """Let nothing more be tried on stdout, also not by the end of the process."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def print_json(content: Mapping[str, Any]) -> None:
    """Print one JSON object on stdout; numbers that are not finite become null."""
    echo(json.dumps(_finite(content), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def print_table(
    head: Sequence[str], rows: Sequence[Sequence[str]], title: str = ""
) -> None:
    """Print a table on stdout; columns headed ``>name`` are aligned right.

    On a terminal too narrow for it every row becomes a paragraph: nothing is cut.
    More than ``MANY`` rows are printed as they are, which Rich takes seconds for.
    """
    if len(rows) > MANY:
        _print_lines(head, rows, title)
        return
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    names = [name.removeprefix(">") for name in head]
    widths = [
        max(len(name), _least_width([r[i] for r in rows], last=i == len(head) - 1))
        for i, name in enumerate(names)
    ]
    if sum(widths) + 3 * len(head) > console.width:
        _print_paragraphs(names, rows, title, console.width)
        return
    table = Table(
        title=Text(shown(title)) if title else None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
    )
    for name, width in zip(head, widths, strict=True):
        table.add_column(
            name.removeprefix(">"),
            justify="right" if name.startswith(">") else "left",
            min_width=width,
            overflow="fold",
        )
    for row in rows:
        table.add_row(*(Text(shown(cell)) for cell in row))
    console.print(table)


def _print_lines(
    head: Sequence[str], rows: Sequence[Sequence[str]], title: str
) -> None:
    names = [name.removeprefix(">") for name in head]
    widths = [max(map(len, column)) for column in zip(names, *rows, strict=True)]
    marks = [
        f"{{:{'>' if name.startswith('>') else '<'}{width}}}"
        for name, width in zip(head, widths, strict=True)
    ]
    line = "  ".join(["", *marks])
    printed = [title] if title else []
    printed += [line.format(*names).rstrip(), "-" * (sum(widths) + 2 * len(widths))]
    printed += [line.format(*row).rstrip() for row in rows]
    echo("\n".join(printed))


def _print_paragraphs(
    names: Sequence[str], rows: Sequence[Sequence[str]], title: str, width: int
) -> None:
    echo(f"\n{title}\n" if title else "")
    for row in rows:
        told = zip(names[1:], row[1:], strict=True)
        facts = "; ".join(f"{name} {cell}" for name, cell in told if cell)
        echo(row[0])
        if facts:
            echo(fill(facts, width, initial_indent="  ", subsequent_indent="  "))


def _least_width(cells: Sequence[str], *, last: bool) -> int:
    """Return the width of a column that is not folded; the last one may wrap."""
    words = [word for cell in cells for word in (cell.split() if last else [cell])]
    return min(48, max(map(len, words), default=0))


@cache
def error_console() -> "Console":
    """Return the one console on stderr, so that logs and bars do not collide."""
    from rich.console import Console

    return Console(stderr=True, width=None if sys.stderr.isatty() else 200)


def set_up_logs(verbose: bool) -> None:
    """Send warnings (with ``verbose`` also notes) of a run to stderr."""
    from rich.logging import RichHandler

    handler = RichHandler(console=error_console(), show_path=False, show_time=False)
    handler.addFilter(_shown)
    log = logging.getLogger("feeddrive")
    log.handlers[:] = [handler]
    log.setLevel(logging.INFO if verbose else logging.WARNING)
    log.propagate = False


def _shown(record: logging.LogRecord) -> bool:
    record.msg, record.args = shown(record.getMessage()), None
    return True


@contextmanager
def waiting(text: str) -> Iterator[None]:
    """Show on a terminal's stderr that something takes a while."""
    if not error_console().is_terminal:
        yield
        return
    with error_console().status(text):
        yield


@contextmanager
def progress_bar(text: str, stop: Fraction) -> Iterator[Progress]:
    """Show on a terminal's stderr how far a run got, and its speed to real time."""
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.3f} of {task.total:.3f} s"),
        TextColumn("{task.fields[factor]}"),
    )
    if not error_console().is_terminal:
        yield lambda t: None
        return
    with Bar(*columns, console=error_console(), transient=True) as bar:
        task = bar.add_task(text, total=float(stop), factor="")
        begun = perf_counter()

        def tell(t: Fraction) -> None:
            factor = float(t) / max(perf_counter() - begun, 1e-9)
            bar.update(task, completed=float(t), factor=f"{factor:.3g} x real time")

        yield tell
