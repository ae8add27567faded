"""Boxes of labels: their attributes, edits and history."""
