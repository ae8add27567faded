"""Checked arrays and HTTP calls, for data of other programs."""
