"""Controllers of the three-axis machine."""
