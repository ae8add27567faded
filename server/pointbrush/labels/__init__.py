"""Palettes, annotations and their history: the label database.

``LabelStore`` is the whole interface; docs/labels.md describes undo and durability.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.labels.accounts import Token
    from pointbrush.labels.backup import move, restore
    from pointbrush.labels.box_attributes import BoxAttribute
    from pointbrush.labels.boxes import BoxEdit, BoxList, Made
    from pointbrush.labels.classes import Category
    from pointbrush.labels.database import Limits
    from pointbrush.labels.integrity import check_database
    from pointbrush.labels.reading import View
    from pointbrush.labels.recordings import KEPT_SECONDS, Known
    from pointbrush.labels.reviews import Review
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
    __getattr__ = lazily(
        __name__,
        {
            "accounts": "Token",
            "backup": "move restore",
            "box_attributes": "BoxAttribute",
            "boxes": "BoxEdit BoxList Made",
            "classes": "Category",
            "database": "Limits",
            "integrity": "check_database",
            "reading": "View",
            "recordings": "KEPT_SECONDS Known",
            "reviews": "Review",
            "store": "LabelStore",
            "types": "Cell Commit Delta EditInfo FrameValues GapError Label Progress Write",
        },
    )
