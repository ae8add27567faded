"""Alembic migrations of the label database, packaged with it."""
