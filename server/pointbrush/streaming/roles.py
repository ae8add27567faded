"""The role that each message of a page needs; a message outside this table is refused."""

from __future__ import annotations

from collections.abc import Mapping

from pointbrush.accounts.roles import Role

MESSAGES: Mapping[str, Role] = {
    "hello": "viewer",
    "open": "viewer",
    "play": "viewer",
    "pause": "viewer",
    "seek": "viewer",
    "credit": "viewer",
    "forget": "viewer",
    "want": "viewer",
    "presence": "viewer",
    "stroke_begin": "annotator",
    "stroke_samples": "annotator",
    "stroke_end": "annotator",
    "stroke_cancel": "annotator",
    "ask": "annotator",
    "undo": "annotator",
    "redo": "annotator",
    "track": "annotator",
}
