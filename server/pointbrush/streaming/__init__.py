"""Frames, label deltas and strokes between the server and its viewers."""
