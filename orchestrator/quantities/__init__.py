"""Numbers with units, exact times, and the instants at which signals are published."""
