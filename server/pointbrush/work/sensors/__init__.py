"""Mounts of the sensors of a recording."""

ALIGN = "alignment"
"""Call in the request of a job that aligns sensors."""
