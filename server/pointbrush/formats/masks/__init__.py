"""Masks of pictures in files: classes and objects of pixels."""
