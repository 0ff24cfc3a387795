"""The table by which the adapters of our FMUs take a composition for one model."""

from collections.abc import Iterator
from fractions import Fraction

from orchestrator.exchange.whole.tables import Tables

BLOCKS = {
    "parameter": "PARAMETER",
    "input": "INPUT",
    "output": "OUTPUT",
    "local": "STATE",
}


def model_table(
    tables: Tables, identifier: str, token: str, clock: Fraction | None
) -> str:
    """Return the C of ``feeddrive_model``, as ``fmus/native/model.h`` declares it.

    Behind the variables stand places that nobody reads: one per component and one
    for the initial circle, named in the message where one of these fails.
    """
    outside = tables.outside
    hidden = [f"a value inside {name}" for name in tables.source.parts]
    hidden.append("what is left of an initial circle")
    named = [
        (one.name, BLOCKS[one.role], int(one.boolean), one.role == "parameter")
        for one in outside
    ]
    named += [(name, "DERIVATIVE", 0, False) for name in hidden]
    named += [("the base period", "PERIOD", 0, False), ("time", "TIME", 0, False)]
    period = tables.source.timetable.schedule.tick
    starts = [float(one.start or 0.0) for one in outside]
    starts += [0.0] * len(hidden) + [float(period), 0.0]
    delays = list(_delays(tables))
    steps = [
        own.equations.numbers["h_max"] for own in tables.source.own.values() if delays
    ]
    fields = {
        "identifier": f'"{identifier}"',
        "token": f'"{token}"',
        "variables": "variables",
        "variable_of": "variable_of",
        "start": "start_of",
        "nominal": "0",
        "size": len(named),
        "u": tables.first("input"),
        "y": tables.first("output"),
        "x": tables.first("local"),
        "der_x": len(outside),
        "T_s": len(named) - 2,
        "n_u": tables.first("output") - tables.first("input"),
        "n_y": tables.first("local") - tables.first("output"),
        "n_x": len(outside) - tables.first("local"),
        "n_d": "(sizeof(Memory) + sizeof(double) - 1) / sizeof(double)",
        "continuous": 0,
        "clock": int(clock is not None),
        "period_num": clock.numerator if clock else 0,
        "period_den": clock.denominator if clock else 1,
        "h_max": max(steps, default=0.0).hex(),
    }
    lines = [f"    .{name} = {value}," for name, value in fields.items()]
    return "\n".join(
        [
            '#include "model.h"',
            "static const Variable variables[] = {",
            *(
                f'    {{"{name}", {i}, 1, {block}, {boolean}, 0, {int(fixed)}}},'
                for i, (name, block, boolean, fixed) in enumerate(named)
            ),
            "};",
            "static const unsigned variable_of[] = {",
            f"    {', '.join(str(i) for i in range(len(named)))}",
            "};",
            "static const double start_of[] = {",
            f"    {', '.join(start.hex() for start in starts)}",
            "};",
            "static const Delay delays[] = {",
            f"    {', '.join(delays or ['{0, 0, 0}'])}",
            "};",
            "const Model feeddrive_model = {",
            *lines,
            "    .delays = delays,",
            f"    .n_delays = {len(delays)},",
            "};",
            "",
        ]
    )


def _delays(tables: Tables) -> Iterator[str]:
    references = {one.name: i for i, one in enumerate(tables.outside)}
    for _, _, name, room in tables.delays():
        yield f"{{0, {references[name]}, {room}}}"
