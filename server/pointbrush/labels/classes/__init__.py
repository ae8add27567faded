"""Palettes of recordings, and the classes of the workspace."""
