"""One module per plant; process loads and disturbances are plants too."""
