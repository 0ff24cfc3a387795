"""A run in the files that other tools read."""
