"""Controllers of the leadscrew mechanism: NCTF, PI-D, and their parts."""
