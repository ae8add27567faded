"""Palettes, annotations and their history: the label database.

``LabelStore`` is the whole interface; see docs/labels.md for what undo means and what survives.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.labels.accounts import Token, Tokens
    from pointbrush.labels.backup import move, restore
    from pointbrush.labels.database import Limits
    from pointbrush.labels.integrity import check_database
    from pointbrush.labels.reading import View
    from pointbrush.labels.recordings import KEPT_SECONDS, Known
    from pointbrush.labels.reviews import Review
    from pointbrush.labels.store import LabelStore
    from pointbrush.labels.taxonomy import Category
    from pointbrush.labels.types import (
        Cell,
        Commit,
        Delta,
        EditInfo,
        FrameValues,
        GapError,
        Label,
        Write,
    )

__all__ = [
    "KEPT_SECONDS",
    "Category",
    "Cell",
    "Commit",
    "Delta",
    "EditInfo",
    "FrameValues",
    "GapError",
    "Known",
    "Label",
    "LabelStore",
    "Limits",
    "Review",
    "Token",
    "Tokens",
    "View",
    "Write",
    "check_database",
    "move",
    "restore",
]
_PLACES = {
    "move": "pointbrush.labels.backup",
    "restore": "pointbrush.labels.backup",
    "Limits": "pointbrush.labels.database",
    "check_database": "pointbrush.labels.integrity",
    "KEPT_SECONDS": "pointbrush.labels.recordings",
    "Known": "pointbrush.labels.recordings",
    "Review": "pointbrush.labels.reviews",
    "LabelStore": "pointbrush.labels.store",
    "Category": "pointbrush.labels.taxonomy",
    "Token": "pointbrush.labels.accounts",
    "Tokens": "pointbrush.labels.accounts",
    "Cell": "pointbrush.labels.types",
    "Commit": "pointbrush.labels.types",
    "Delta": "pointbrush.labels.types",
    "EditInfo": "pointbrush.labels.types",
    "FrameValues": "pointbrush.labels.types",
    "GapError": "pointbrush.labels.types",
    "Label": "pointbrush.labels.types",
    "View": "pointbrush.labels.reading",
    "Write": "pointbrush.labels.types",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
