"""People and other large things that bend."""
