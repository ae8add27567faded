"""Tracking runs as jobs, and the commit of their results."""

TRACK = "track"
"""Call in the request of a tracking job."""
