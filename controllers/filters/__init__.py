"""Filters that serve several drives."""
