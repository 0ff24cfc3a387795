"""Trajectories, paths and test signals that serve several drives."""
