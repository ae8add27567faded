"""Compiling of the loops over points, once on each machine."""
