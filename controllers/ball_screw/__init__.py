"""Controllers of the ball-screw drive: MC-PPC, P-PI, and their parts."""
