"""Point cloud files: every reader and exporter, behind one registry."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.formats.exports import (
        EXPORTS,
        BlockedFrame,
        Export,
        ExportFrame,
        LabeledFrame,
        Split,
        category_names,
        export,
        sizes_of,
    )
    from pointbrush.formats.options import Limits, ReadOptions
    from pointbrush.formats.palette import SourceLabel, own_labels
    from pointbrush.formats.registry import FORMATS, Format, format_named, format_names
    from pointbrush.formats.source import Source, open_source, read, reported, source_name

__all__ = [
    "EXPORTS",
    "FORMATS",
    "BlockedFrame",
    "Export",
    "ExportFrame",
    "Format",
    "LabeledFrame",
    "Limits",
    "ReadOptions",
    "Source",
    "SourceLabel",
    "Split",
    "category_names",
    "export",
    "format_named",
    "format_names",
    "open_source",
    "own_labels",
    "read",
    "reported",
    "sizes_of",
    "source_name",
]
_PLACES = {
    "EXPORTS": "pointbrush.formats.exports",
    "BlockedFrame": "pointbrush.formats.exports",
    "Export": "pointbrush.formats.exports",
    "ExportFrame": "pointbrush.formats.exports",
    "LabeledFrame": "pointbrush.formats.exports",
    "Split": "pointbrush.formats.exports",
    "category_names": "pointbrush.formats.exports",
    "export": "pointbrush.formats.exports",
    "sizes_of": "pointbrush.formats.exports",
    "Limits": "pointbrush.formats.options",
    "ReadOptions": "pointbrush.formats.options",
    "SourceLabel": "pointbrush.formats.palette",
    "own_labels": "pointbrush.formats.palette",
    "FORMATS": "pointbrush.formats.registry",
    "Format": "pointbrush.formats.registry",
    "format_named": "pointbrush.formats.registry",
    "format_names": "pointbrush.formats.registry",
    "Source": "pointbrush.formats.source",
    "open_source": "pointbrush.formats.source",
    "read": "pointbrush.formats.source",
    "reported": "pointbrush.formats.source",
    "source_name": "pointbrush.formats.source",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
