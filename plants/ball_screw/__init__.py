"""Ball-screw drive of the pole-placement study: screw, table, amplifier, encoders."""
