"""What a run makes of what was found, and learns from it."""
