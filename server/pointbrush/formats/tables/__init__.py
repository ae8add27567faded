"""Columns of points: their roles, names and numbers, and the classes of label files."""
