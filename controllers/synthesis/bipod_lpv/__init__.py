"""Designs for the bipod."""
