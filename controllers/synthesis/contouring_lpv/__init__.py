"""Designs for contouring on the three-axis machine."""
