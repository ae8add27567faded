"""Common base of the parts of a workspace that edit labels of recordings."""

from __future__ import annotations

from collections.abc import Callable

from pointbrush.labels import LabelStore
from pointbrush.sequences import Sequence as Recording


class Part:
    """Edits of recordings by id; thread-safe.

    Every method raises NotFoundError for an unknown sequence or frame, DamagedError.
    """

    def __init__(self, store: LabelStore, recording: Callable[[str], Recording]) -> None:
        """``recording``: opens a recording by its id."""
        self._store, self._recording = store, recording
