"""System structure packages (SSP 1.0 and 2.0), to and from other tools."""
