"""Edits of points: strokes, erasing, copying, splitting, the layers of an annotated frame."""
