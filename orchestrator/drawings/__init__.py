"""Figures of the sources, drawn by their numbers from what we compute."""
