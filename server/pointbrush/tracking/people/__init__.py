"""People and other large objects that bend."""
