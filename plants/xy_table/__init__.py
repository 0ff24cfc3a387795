"""XY ball-screw table, identified from its frequency response."""
