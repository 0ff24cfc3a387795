"""How a model becomes an FMU; knows nothing of plants or controllers."""
