"""Folders held while they are in use, and temporary ones."""
