"""Boxes and marked points of other tools; see docs/conventions.md."""
