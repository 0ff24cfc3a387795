"""Scenarios: what a TOML file says, checked, composed into a system."""
