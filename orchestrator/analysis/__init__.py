"""Questions put to a scenario many times over: sweeps, fits, tuning."""
