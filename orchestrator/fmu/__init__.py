"""What an FMU says of itself, its archive, its variables seen from a composition."""
