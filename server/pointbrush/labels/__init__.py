"""Palettes, annotations and their history: the label database.

``LabelStore`` is the whole interface; see docs/labels.md for what undo means and what survives.
"""

from pointbrush.labels.backup import move, restore
from pointbrush.labels.database import Limits
from pointbrush.labels.integrity import check_database
from pointbrush.labels.recordings import KEPT_SECONDS, Known
from pointbrush.labels.store import LabelStore
from pointbrush.labels.taxonomy import Category
from pointbrush.labels.tokens import Token, Tokens
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
    "Token",
    "Tokens",
    "Write",
    "check_database",
    "move",
    "restore",
]
