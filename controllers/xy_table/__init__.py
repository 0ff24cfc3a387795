"""Controllers of the XY table: cascades P/PI and NP/PI, and their parts."""
