"""Where runs are kept: folders taken, listed and removed."""
