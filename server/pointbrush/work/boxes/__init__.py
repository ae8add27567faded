"""Oriented boxes and the points in them."""

FIT = "fitting"
"""Call in the request of a job that fits boxes to labels."""
