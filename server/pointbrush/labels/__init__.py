"""Palettes, annotations and their history.

``LabelStore`` is the whole interface; docs/labels.md describes undo and durability.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.labels.boxes.editing import BoxEdit, BoxList, Made
    from pointbrush.labels.classes.changes import Category
    from pointbrush.labels.reading import View
    from pointbrush.labels.recordings import KEPT_SECONDS, Known
    from pointbrush.labels.store import LabelStore
    from pointbrush.labels.types import (
        Cell,
        Commit,
        Delta,
        EditInfo,
        FrameValues,
        GapError,
        Label,
        Progress,
        Write,
    )
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
