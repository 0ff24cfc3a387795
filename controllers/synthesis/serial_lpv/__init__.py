"""Designs for the serial machine, two ball-screw axes."""
