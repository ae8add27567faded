"""Backups of a workspace: one archive, or a series with expiry."""
