"""Frequency responses of a composition, measured by what the master injects."""
