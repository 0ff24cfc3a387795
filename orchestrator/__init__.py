"""Co-simulation of FMU files at exact mixed rates."""
