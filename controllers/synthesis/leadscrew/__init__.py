"""Offline design of the leadscrew mechanism."""
