"""A rope that pulls at a two-mass drive and snaps: the scenario of small studies."""

SCENARIO = """
stop = "0.01"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/20000"
[components.rope]
fmu = "plants.disturbances.rope_snap"
step = "1/20000"
parameters = { t_0 = 0 }
[connections]
"plant.d_2" = "rope.d_2"
[record]
"rope.d_2" = true
"plant.x_2" = true
[metrics]
pull = { kind = "peak", of = "rope.d_2", unit = "mV" }
"""
