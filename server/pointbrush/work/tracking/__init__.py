"""Tracking runs as jobs, and how their findings reach the label store."""

TRACK = "track"
"""Of a job's request: a tracking run."""
