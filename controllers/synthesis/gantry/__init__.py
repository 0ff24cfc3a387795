"""Offline design of the gantry."""
