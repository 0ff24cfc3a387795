"""The verb ``build``: FMUs and plain C of models and of components of scenarios."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.fmus import Json, model_modules
from orchestrator.cli.output import executing, print_json, print_table, waiting
from orchestrator.cli.rows import Between, Rate, interpolation, time

if TYPE_CHECKING:
    from orchestrator.cli.designed import Designed
    from orchestrator.signals.ticks import Interpolation


@dataclass(frozen=True)
class Order:
    """What is to be built of every model."""

    kind: Any
    period: Fraction | None
    platforms: list[str] | None
    clock: bool
    real: Any
    interpolation: "Interpolation"
    rate: Fraction | None


@executing
def build(
    modules: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[MODEL]...",
            help="plants.x, controllers.y, model.py, supplied.ball_screw, or "
            "SCENARIO:component with the values it runs with there, or signals.csv "
            "(.parquet, .mat)",
        ),
    ] = None,
    all_: Annotated[bool, typer.Option("--all", help="build every model")] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="folder [dist/fmus, dist/c]")
    ] = None,
    form: Annotated[str, typer.Option(help="fmu, or c: plain C, no FMI")] = "fmu",
    kind: Annotated[str, typer.Option(help="native or python")] = "native",
    fmi: Annotated[
        int | None, typer.Option(help="2 or 3 [2; with --all and native both]")
    ] = None,
    period: Annotated[
        str | None, typer.Option(help='sample time of sampled models, e.g. "1/10000"')
    ] = None,
    clock: Annotated[
        bool,
        typer.Option("--clock/--no-clock", help="input clock of sampled models, FMI 3"),
    ] = True,
    real: Annotated[str, typer.Option(help="double or float, of plain C")] = "double",
    between: Between = "hold",
    rate: Rate = None,
    platform: Annotated[
        list[str] | None,
        typer.Option(
            help="all, or a platform such as linux-x86_64 or win64 (repeatable) "
            "[that of this machine]"
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Build FMUs of models and show their sizes and build times."""
    from fmus.compile import PLATFORMS
    from orchestrator.errors import ScenarioError

    if form not in ("fmu", "c"):
        raise ScenarioError(f"--form {form}: choose fmu or c")
    names = [*(modules or []), *(model_modules() if all_ else [])]
    if all_:
        names = [n for n in names if form == "fmu" or _sampled(n)]
    if not names:
        raise ScenarioError("name the modules to build, or give --all")
    both = all_ and kind == "native" and fmi is None
    versions: list[Any] = ["c"] if form == "c" else [2, 3] if both else [fmi or 2]
    chosen = list(PLATFORMS) if platform == ["all"] else platform
    played = interpolation(between), time(rate, "--rate")
    order = Order(kind, time(period, "--period"), chosen, clock, real, *played)
    output = output or Path("dist", "c" if form == "c" else "fmus")
    built = []
    for version in versions:
        folder = output / f"fmi{version}" if len(versions) > 1 else output
        what = "plain C" if version == "c" else f"FMI {version}"
        for name in names:
            with waiting(f"building {name} as {what}"):
                built.append(_build(name, folder, version, order, all_))
    if json:
        print_json({"fmus": built})
        return
    rows = [
        [
            b["module"],
            b["kind"] if b["fmi"] is None else f"FMI {b['fmi']}",
            f"{b['bytes'] / 1024:.0f} KiB",
            f"{b['seconds']:.2f} s",
            b["file"],
        ]
        for b in built
    ]
    print_table(["module", "form", ">size", ">time", "file"], rows)


def _sampled(module: str) -> bool:
    from fmus.build import load_model
    from fmus.model import Sampled

    return isinstance(load_model(module), Sampled)


def _build(
    name: str, folder: Path, fmi: Any, order: Order, every: bool
) -> dict[str, Any]:
    """Build one; a period for all models is not meant for continuous ones."""
    import fmus.build
    from orchestrator.cli.designed import designed
    from orchestrator.errors import ScenarioError
    from orchestrator.signals.columns import FORMS
    from orchestrator.supplied import PREFIX, build_supplied

    begun = perf_counter()
    try:
        if Path(name).suffix.lower() in FORMS:
            return _signals(name, folder, fmi, order, begun)
        of = designed(name)
        if name.startswith(PREFIX):
            file = build_supplied(name, folder)
        elif fmi == "c":
            options = _options(of, order, every)
            file = fmus.build.build_c(
                of.module, folder=folder, real=order.real, **options
            )
        else:
            file = fmus.build.build(
                of.module,
                kind=order.kind,
                fmi=fmi,
                clock=order.clock,
                platforms=order.platforms,
                folder=folder,
                **_options(of, order, every),
            )
    except fmus.build.BuildError as error:
        raise ScenarioError(f"{name}: {error}") from None
    return _told(name, file, fmi, order.kind, begun)


def _signals(
    name: str, folder: Path, fmi: Any, order: Order, begun: float
) -> dict[str, Any]:
    """Build the FMU of a file of signals."""
    from orchestrator.errors import ScenarioError
    from orchestrator.signals.recording import Recording, play

    if fmi == "c" or order.kind != "native":
        raise ScenarioError(f"{name}: signals of a file become a native FMU alone")
    recording = Recording(
        Path(name), order.period, order.interpolation, rate=order.rate
    )
    options = {"clock": order.clock, "platforms": order.platforms, "folder": folder}
    return _told(name, play(recording, fmi=fmi, **options).fmu, fmi, "native", begun)


def _told(name: str, file: Path, fmi: Any, kind: Any, begun: float) -> dict[str, Any]:
    files = [file] if file.is_file() else file.iterdir()
    return {
        "module": name,
        "kind": "c" if fmi == "c" else kind,
        "fmi": None if fmi == "c" else fmi,
        "file": str(file),
        "bytes": sum(one.stat().st_size for one in files),
        "seconds": perf_counter() - begun,
    }


def _options(of: "Designed", order: Order, every: bool) -> dict[str, Any]:
    period = of.period if order.period is None else order.period
    if every and period is not None and not _sampled(of.module):
        period = None
    return {"period": period, "values": of.values, "origin": of.origin}
