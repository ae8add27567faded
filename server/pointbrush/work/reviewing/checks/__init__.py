"""Suspicious things: each check is a function of what was gathered, in a module of its own."""
