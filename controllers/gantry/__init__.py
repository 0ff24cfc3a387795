"""Controllers of the gantry: averaged MIMO, independent PID, x axis, their parts."""
