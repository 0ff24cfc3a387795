"""Controllers of the bipod."""
