"""Designs for the ball screw with varying dynamics."""
