"""Sensors that serve several drives."""
