"""The verb ``export``: a run, or a composition, in a file that other tools read."""

from fractions import Fraction
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.completion import run_names
from orchestrator.cli.output import echo, executing, print_json, waiting
from orchestrator.cli.run import Fmi as FmiOption
from orchestrator.cli.run import Json, Maps, Sets, Swaps


@executing
def export(
    run: Annotated[
        str,
        typer.Argument(
            metavar="RUN",
            help="a folder, or a name that `runs` lists; for .ssp and .fmu a scenario",
            autocompletion=run_names,
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="FILE", help="x.csv, x.mat, x.h5, x.ssp or x.fmu"
        ),
    ],
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="RATE", help='only rows of one rate, "1 kHz"'),
    ] = None,
    ssp: Annotated[
        str | None, typer.Option("--ssp", help="version of SSP, 1.0 or 2.0 [1.0]")
    ] = None,
    sets: Sets = [],  # noqa: B006 - Typer copies it
    swap: Swaps = [],  # noqa: B006
    map: Maps = [],  # noqa: B006
    fmi: FmiOption = None,
    inputs: Annotated[
        str | None,
        typer.Option("--inputs", help="free inputs of an .fmu: plant.d,drive.x_r"),
    ] = None,
    outputs: Annotated[
        str | None,
        typer.Option("--outputs", help="outputs of an .fmu [all that is recorded]"),
    ] = None,
    platform: Annotated[
        list[str],
        typer.Option(
            "--platform",
            help="binaries of .fmu, or of FMUs in .ssp (repeatable)",
        ),
    ] = [],  # noqa: B006
    no_clock: Annotated[
        bool,
        typer.Option(
            "--no-clock", help="an .fmu of FMI 3 without its clock, as late as FMI 2"
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Write the rows of a run (CSV, MAT as Dymola does, HDF5), or a scenario as SSP
    or one FMU.

    The suffix of the file says which.
    """
    from orchestrator.errors import ScenarioError
    from orchestrator.exchange.tables import export as write

    scenario_only = (ssp, sets, swap, map, fmi, inputs, outputs, platform)
    if output.suffix.lower() == ".fmu":
        if at is not None or ssp is not None:
            raise ScenarioError(
                f"{output}: a composition becomes an FMU with --fmi, --inputs, "
                f"--outputs and --platform"
            )
        ends = _listed(inputs), _listed(outputs)
        of = run, sets, swap, map, output
        written = _whole(*of, *ends, platform, fmi, clock=not no_clock)
    elif no_clock:
        raise ScenarioError(f"{output}: --no-clock is for a composition as one .fmu")
    elif inputs or outputs:
        raise ScenarioError(
            f"{output}: --inputs and --outputs are for a composition as one .fmu"
        )
    elif output.suffix.lower() == ".ssp":
        if at is not None:
            raise ScenarioError("--at: chooses rows of a run, and an .ssp holds none")
        written = _package(run, sets, swap, map, fmi, output, ssp, platform)
    elif any(scenario_only):
        raise ScenarioError(
            f"{output}: --ssp, --set, --swap, --map, --fmi and --platform are for a "
            f"scenario as .ssp; the rows of a run are written as they are"
        )
    else:
        written = write(_folder(run), output, _period(at))
    if json:
        print_json({"file": str(written), "bytes": written.stat().st_size})
    else:
        echo(f"written to {written}: {written.stat().st_size:,} bytes")


def _period(at: str | None) -> Fraction | None:
    from orchestrator.errors import ScenarioError
    from orchestrator.quantities.quantity import parse_period

    try:
        return None if at is None else parse_period(at)
    except ValueError as error:
        raise ScenarioError(f"--at: {error}") from None


def _package(
    name: str,
    sets: list[str],
    swaps: list[str],
    maps: list[str],
    fmi: int | None,
    output: Path,
    version: str | None,
    platforms: list[str],
) -> Path:
    from fmus.compile import platforms_named
    from orchestrator.cli.running import load
    from orchestrator.exchange.ssp.write import export_ssp
    from orchestrator.scenario.compose import compose
    from orchestrator.session import naming, run_earlier

    scenario = load(name, sets, swaps, maps, fmi)
    with naming(scenario), waiting(f"building the FMUs of {scenario.name}"):
        wanted = [one for name in platforms for one in platforms_named(name)]
        return export_ssp(compose(scenario, run_earlier), output, version, wanted)


def _listed(names: str | None) -> list[str]:
    return [name.strip() for name in (names or "").split(",") if name.strip()]


def _whole(
    name: str,
    sets: list[str],
    swaps: list[str],
    maps: list[str],
    output: Path,
    inputs: list[str],
    outputs: list[str],
    platforms: list[str],
    fmi: int | None,
    *,
    clock: bool,
) -> Path:
    from fmus.compile import platforms_named
    from fmus.subject import Fmi
    from orchestrator.cli.running import load
    from orchestrator.errors import ScenarioError
    from orchestrator.exchange.whole.export import export_whole
    from orchestrator.scenario.compose import compose
    from orchestrator.session import naming, run_earlier

    version: Fmi = 3 if fmi == 3 else 2
    if fmi not in (None, 2, 3):
        raise ScenarioError(f"--fmi {fmi}: there are FMI 2 and 3")
    scenario = load(name, sets, swaps, maps, None)
    wanted = [one for name in platforms for one in platforms_named(name)]
    with naming(scenario), waiting(f"building {output.name}"):
        composition = compose(scenario, run_earlier)
        ends = inputs, outputs, wanted, version
        return export_whole(composition, output, *ends, clock=clock)


def _folder(name: str) -> Path:
    """Return the folder of a run given by path, or by its name in runs/."""
    from orchestrator.history.folder import RUNS
    from orchestrator.history.listing import entries, find

    folder = Path(name)
    if (folder / "result").is_dir():
        return folder
    known = entries(RUNS)
    inside = str(folder).removeprefix(f"{RUNS}/")
    return find(inside, known).folder
