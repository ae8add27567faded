"""Point cloud files: every reader and exporter, behind one registry."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.formats.options import Limits, ReadOptions
    from pointbrush.formats.registry import FORMATS, Format, format_names
    from pointbrush.formats.source import open_source, read, reported, source_name
    from pointbrush.formats.tables.palette import own_labels
    from pointbrush.formats.writers import EXPORTS, export
    from pointbrush.formats.writers.labeled import BlockedFrame, ExportFrame, LabeledFrame, Split
    from pointbrush.formats.writers.sensors import sensor_frames, with_sensor_fields
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
