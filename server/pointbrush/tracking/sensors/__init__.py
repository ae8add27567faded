"""Kinds of sensors, their trajectories, and views of their frames."""
