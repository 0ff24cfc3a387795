"""Loads, disturbances and excitations that serve several drives."""
