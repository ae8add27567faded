"""``python -m pointbrush.settings`` writes the tables of docs/options.md."""

from pointbrush.settings.documentation import DOCS, documented

DOCS.write_text(documented(DOCS.read_text(encoding="utf-8")), encoding="utf-8")
