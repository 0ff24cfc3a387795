"""Modules that have moved since the first edition: old name, new name.

An old name is refused with the new one; it is no second way to name a model.
"""

_MOVED = """
controllers.circle_path controllers.references.circle_path
controllers.circle_reference controllers.references.circle
controllers.conditional_notch controllers.leadscrew.conditional_notch
controllers.current_pulse controllers.references.current_pulse
controllers.diamond_path controllers.references.diamond_path
controllers.diamond_reference controllers.references.diamond
controllers.double_lead controllers.gantry.double_lead
controllers.filter_pack controllers.ball_screw.filter_pack
controllers.friction_feedforward controllers.ball_screw.friction_feedforward
controllers.gain_ramp controllers.xy_table.gain_ramp
controllers.gantry_averaging controllers.gantry.averaging
controllers.gantry_end_pid controllers.gantry.end_pid
controllers.gantry_feedforward controllers.gantry.feedforward
controllers.gantry_filters controllers.gantry.filters
controllers.gantry_mimo controllers.gantry.mimo
controllers.gantry_pid controllers.gantry.pid
controllers.gantry_prefilter controllers.gantry.prefilter
controllers.gantry_schedule controllers.gantry.schedule
controllers.gantry_x controllers.gantry.x
controllers.gantry_x_filters controllers.gantry.x_filters
controllers.inertia_feedforward controllers.ball_screw.inertia_feedforward
controllers.line_path controllers.references.line_path
controllers.linear_prefilter controllers.filters.linear_prefilter
controllers.mass_feedforward controllers.gantry.mass_feedforward
controllers.mc_ppc controllers.ball_screw.mc_ppc
controllers.model_inversion controllers.ball_screw.model_inversion
controllers.nct_compensator controllers.leadscrew.compensator
controllers.nct_element controllers.leadscrew.nominal_trajectory
controllers.nctf controllers.leadscrew.nctf
controllers.nctf_gain_stairs controllers.leadscrew.gain_stairs
controllers.np_pi controllers.xy_table.np_pi
controllers.np_position controllers.xy_table.position_np
controllers.p_pi controllers.ball_screw.p_pi
controllers.p_pi_cascade controllers.xy_table.p_pi
controllers.pi_d controllers.leadscrew.pi_d
controllers.position_p controllers.ball_screw.position_p
controllers.prefilter controllers.filters.prefilter
controllers.rotary_command controllers.ball_screw.rotary_command
controllers.sine_reference controllers.references.sine
controllers.speed_pi controllers.xy_table.speed_pi
controllers.stair_reference controllers.references.stair
controllers.state_feedback controllers.ball_screw.state_feedback
controllers.synthesis.ball_screw_continuous controllers.synthesis.ball_screw.continuous
controllers.synthesis.ball_screw_loops controllers.synthesis.ball_screw.loops
controllers.synthesis.friction_lookup controllers.synthesis.leadscrew.friction_lookup
controllers.synthesis.gantry_continuous controllers.synthesis.gantry.continuous
controllers.synthesis.gantry_design controllers.synthesis.gantry.design
controllers.synthesis.gantry_identification controllers.synthesis.gantry.identification
controllers.synthesis.gantry_loops controllers.synthesis.gantry.loops
controllers.synthesis.nct controllers.synthesis.leadscrew.nct
controllers.synthesis.nct_stability controllers.synthesis.leadscrew.stability
controllers.synthesis.pole_placement controllers.synthesis.ball_screw.pole_placement
controllers.synthesis.xy_table_loops controllers.synthesis.xy_table.loops
controllers.trajectory controllers.references.trajectory
controllers.velocity_estimator controllers.xy_table.velocity_estimator
controllers.velocity_pi controllers.ball_screw.velocity_pi
plants.ball_screw plants.ball_screw.two_mass
plants.ball_screw_drive plants.ball_screw.drive
plants.current_loop plants.ball_screw.current_loop
plants.encoder plants.ball_screw.encoder
plants.excitation plants.disturbances.sine
plants.gantry plants.gantry.frame
plants.gantry_drive plants.gantry.drive
plants.gantry_encoder plants.gantry.encoder
plants.laser_sensor plants.sensors.laser
plants.leadscrew plants.leadscrew.axis
plants.linear_motor plants.gantry.x_axis
plants.linear_motor_drive plants.gantry.x_drive
plants.multisine plants.disturbances.multisine
plants.pitch_mode plants.ball_screw.pitch_mode
plants.rope_snap plants.disturbances.rope_snap
plants.simplified_object plants.leadscrew.simplified
plants.slotting_force plants.disturbances.slotting_force
plants.xy_table plants.xy_table.axis
"""
MOVED = dict(line.split() for line in _MOVED.strip().splitlines())


def refusal(module: str) -> str | None:
    """Return the sentence for a name that has moved, None for any other."""
    return f"{module} is {MOVED[module]}" if module in MOVED else None
