"""The work of a run in two processes."""
