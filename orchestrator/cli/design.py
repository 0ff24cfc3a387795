"""The verb ``design``: shipped tables made anew, and what that changes."""

from dataclasses import asdict
from typing import Annotated

import typer

from orchestrator.cli.output import echo, executing, print_json, print_table, waiting
from orchestrator.cli.run import Json


@executing
def design(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="ball_screw_lpv.k_vib; none lists all"),
    ] = None,
    write: Annotated[
        bool, typer.Option("--write", help="replace the shipped files")
    ] = False,
    json: Json = False,
) -> None:
    """Make a shipped design anew and show what changed; list them without a name."""
    from orchestrator.analysis.redesign import (
        compare,
        find_design,
        make_anew,
        shipped_designs,
    )
    from orchestrator.analysis.redesign import write as replace
    from orchestrator.errors import ScenarioError

    if name is None:
        if write:
            raise ScenarioError("name the design to write")
        found = shipped_designs().values()
        if json:
            print_json({"designs": [d.name for d in found]})
        else:
            print_table(
                ["design", "files in"], [[d.name, str(d.folder)] for d in found]
            )
        return
    chosen = find_design(name)
    with waiting(f"designing {name}"):
        files = make_anew(chosen)
    changes = list(compare(chosen, files))
    if write:
        replace(chosen, files)
    if json:
        changed = [asdict(change) for change in changes]
        print_json({"design": name, "changes": changed, "written": write})
        return

    def shown(value: float | None) -> str:
        return "" if value is None else f"{value:.6g}"

    rows = [
        [c.file, c.quantity, shown(c.before), shown(c.after), shown(c.difference)]
        for c in changes
    ]
    head = ["file", "quantity", ">shipped", ">anew", ">relative difference"]
    print_table(head, rows)
    told = ", ".join(str(chosen.folder / file) for file in files)
    echo(f"written: {told}" if write else "nothing written (--write does)")
