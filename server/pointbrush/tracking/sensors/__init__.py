"""Sensors: what they are, where they were, and the frames that they give."""
