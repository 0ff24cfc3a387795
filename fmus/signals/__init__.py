"""FMUs of recorded signals: a table of numbers in the archive instead of equations."""
