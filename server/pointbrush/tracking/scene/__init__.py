"""The scene at rest."""
