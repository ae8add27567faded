"""Compiled loops over points."""
