"""libcosim, through libcosimpy: fixed step in whole nanoseconds, FMI 2."""

from collections.abc import Iterator
from typing import Any


def rows(job: dict[str, Any]) -> Iterator[list[float]]:
    """Yield libcosim's own time and the signals after every step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    num, den = job["period"]
    if 10**9 * num % den:
        raise ValueError(f"a step of {num}/{den} s is no whole number of nanoseconds")
    execution = CosimExecution.from_step_size(10**9 * num // den)
    slaves = {}
    for name, component in job["components"].items():
        if component["fmi"] != 2:
            raise ValueError(f"{name} is FMI {component['fmi']}; it takes FMI 2 only")
        slave = CosimLocalSlave(fmu_path=component["fmu"], instance_name=name)
        slaves[name] = execution.add_local_slave(slave)
        if slaves[name] < 0:
            raise RuntimeError(f"libcosim did not load {component['fmu']}")
    for name, component in job["components"].items():
        setters = {
            "real": (execution.real_initial_value, float),
            "boolean": (execution.boolean_initial_value, bool),
            "integer": (execution.integer_initial_value, int),
        }
        for variable, reference, sort, value in component["start"]:
            write, kind = setters[sort]
            if not write(slaves[name], reference, kind(value)):
                raise RuntimeError(f"libcosim did not set {name}.{variable}")
    for connection in job["connections"]:
        _connect(execution, slaves, connection)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    readers = {
        "real": observer.last_real_values,
        "boolean": observer.last_boolean_values,
        "integer": observer.last_integer_values,
    }
    for _ in range(job["count"]):
        if not execution.step():
            raise RuntimeError(f"libcosim stopped: {execution.status()}")
        time = execution.status().current_time / 1e9
        signals = (
            readers[sort](slaves[name], [reference])[0]
            for name, _, reference, sort in job["signals"]
        )
        yield [time, *map(float, signals)]


def _connect(
    execution: Any, slaves: dict[str, int], connection: dict[str, Any]
) -> None:
    if (connection["gain"], connection["offset"]) != (1.0, 0.0):
        raise ValueError(
            f"{'.'.join(connection['sink'][:2])} needs a conversion of units, which "
            f"a connection of libcosimpy cannot do"
        )
    (source, _, output, sort), (sink, _, taken, _) = (
        connection["source"],
        connection["sink"],
    )
    connect = getattr(execution, f"connect_{sort}_variables")
    connect(slaves[source], output, slaves[sink], taken)
