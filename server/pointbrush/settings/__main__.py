"""``python -m pointbrush.settings`` writes the tables of docs/options.md."""

from pointbrush.settings.documentation import DOCS, with_new_tables

DOCS.write_text(with_new_tables(DOCS.read_text(encoding="utf-8")), encoding="utf-8")
