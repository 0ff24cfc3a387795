"""Bipod: a parallel machine of two sliders on one rail."""
