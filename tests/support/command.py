"""A scenario for the command, and what a refusal of it looks like."""

TRACK = "ball_screw_pole_placement/mc_ppc_track_500"
DRIVE = """
stop = "0.01"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/20000"
[components.source]
fmu = "plants.disturbances.rope_snap"
step = "1/20000"
[connections]
"plant.d_2" = "source.d_2"
[record]
"plant.x_2" = true
[metrics]
x = { kind = "peak", of = "plant.x_2", unit = "deg" }
"""


def refused(result, *parts, code=2):
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output
    assert result.exception is None or isinstance(result.exception, SystemExit)
    *_, message = result.stderr.strip().partition("error: ")  # logs may precede it
    message = message or result.stderr
    assert "\n\n" not in message
    for part in parts:
        assert str(part) in message
