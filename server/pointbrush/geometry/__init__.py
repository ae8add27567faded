"""Oriented boxes, their overlap, and rotations as quaternions."""
