"""The database of a workspace: tables, migrations, statements, backups, notification of commits."""
