"""FMUContainer, of fmu-manipulation-toolbox: the system as one FMU, built here.

``rows`` yields nothing: it leaves ``container.fmu`` in the job's folder, to be
run by another tool.  Its outputs are called ``seen.<component>.<variable>``,
as it has locals without the prefix.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any


def rows(job: dict[str, Any]) -> Iterator[list[float]]:
    """Build the container."""
    from fmu_manipulation_toolbox.assembly import Assembly, AssemblyNode

    folder = Path(job["folder"])
    node = AssemblyNode(
        "container.fmu",
        step_size=job["step"],
        auto_link=False,
        auto_input=False,
        auto_output=False,
    )
    for name, component in job["components"].items():
        place = folder / f"{name}.fmu"
        place.write_bytes(Path(component["fmu"]).read_bytes())
        node.add_fmu(place.name)
        for variable, _, sort, value in component["start"]:
            number = repr(value if sort == "real" else int(value))
            node.add_start_value(place.name, variable, number)
    for connection in job["connections"]:
        if (connection["gain"], connection["offset"]) != (1.0, 0.0):
            raise ValueError(
                f"{'.'.join(connection['sink'][:2])} needs a conversion of units, "
                f"which a link of FMUContainer cannot do"
            )
        source, sink = connection["source"], connection["sink"]
        node.add_link(f"{source[0]}.fmu", source[1], f"{sink[0]}.fmu", sink[1])
    for component_name, variable, _, _ in job["signals"]:
        node.add_output(
            f"{component_name}.fmu", variable, f"seen.{component_name}.{variable}"
        )
    assembly = Assembly(fmu_directory=folder)
    assembly.root = node
    assembly.make_fmu()
    return iter(())
