"""Tracking runs as jobs, and how their findings reach the label store."""
