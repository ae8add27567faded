"""Boxes and marked points that other tools keep of frames; see docs/conventions.md."""
