"""Offline design: plain parameters and arrays in, run-time parameters out."""
