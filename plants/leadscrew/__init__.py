"""Leadscrew mechanism with presliding friction."""
