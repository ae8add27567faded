"""Oriented boxes and the points in them."""

FIT = "fitting"
"""Of a job's request: boxes fitted to labels."""
