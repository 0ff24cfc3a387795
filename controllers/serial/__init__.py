"""Controllers of the serial machine."""
