"""Masks of the pictures of a recording, as labels of its points and back."""
