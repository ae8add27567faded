"""Which points of a frame are whose."""
