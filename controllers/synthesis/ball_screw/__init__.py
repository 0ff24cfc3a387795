"""Offline design of the ball-screw drive."""
