"""Offline design of the XY table."""
