"""Poses of sensors, and the alignment of frames."""
