"""Recordings of several sensors: their mounts, and the joining of their frames by time."""
