"""Bands of figures that rest on numbers which their source does not print."""
