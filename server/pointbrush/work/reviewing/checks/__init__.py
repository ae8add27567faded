"""Checks, each a function of collected data, grouped in modules by data."""
