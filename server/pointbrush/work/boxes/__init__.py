"""Oriented boxes and the points in them."""
