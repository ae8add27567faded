"""Point cloud files: every reader and exporter, behind one registry."""

from __future__ import annotations

from pointbrush.formats.exports import (
    EXPORTS,
    BlockedFrame,
    Export,
    ExportFrame,
    LabeledFrame,
    category_names,
    export,
    sizes_of,
)
from pointbrush.formats.options import Limits, ReadOptions
from pointbrush.formats.palette import SourceLabel, source_palette
from pointbrush.formats.registry import FORMATS, Format, format_named, format_names
from pointbrush.formats.source import Source, open_source, read, source_name

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
    "category_names",
    "export",
    "format_named",
    "format_names",
    "open_source",
    "read",
    "sizes_of",
    "source_name",
    "source_palette",
]
