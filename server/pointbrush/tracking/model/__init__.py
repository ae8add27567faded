"""Parts of a track: surface, motion, appearance, confidence."""
