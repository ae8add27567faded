"""Frames of depth cameras: their pixel lattice, and depth images on the wire."""
