"""Seconds and strokes that people spent on frames, from the times of their edits."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pointbrush.labels import EditInfo

STROKES = frozenset({"paint", "erase", "delete", "restore"})
MACHINE = frozenset({"tracking", "import"})
"""Kinds of edits that a person waits for and does not make."""


@dataclass(frozen=True, slots=True)
class EffortOptions:
    """``idle`` seconds without an edit are a pause; ``first``: what an edit after one counts."""

    idle: float = 60.0
    first: float = 5.0

    def __post_init__(self) -> None:
        if not 0 <= self.first <= self.idle:
            raise ValueError("first: expected 0 to idle seconds")


@dataclass(slots=True)
class Effort:
    """Seconds, strokes and edits of a person in a frame, or of several together."""

    seconds: float = 0.0
    strokes: int = 0
    edits: int = 0

    def add(self, other: Effort) -> None:
        """Add another's."""
        self.seconds += other.seconds
        self.strokes += other.strokes
        self.edits += other.edits


def effort_of(
    edits: Iterable[EditInfo], options: EffortOptions | None = None
) -> Mapping[tuple[int | None, str], Effort]:
    """Return effort by frame and author; frame None: edits of no frame, as of the palette.

    ``edits`` are in the order of their times.  The time since an author's last edit goes to the
    frames of the next one, in equal parts; each of them gets its stroke.
    """
    options = options or EffortOptions()
    last: dict[str, float] = {}
    found: dict[tuple[int | None, str], Effort] = defaultdict(Effort)
    for edit in edits:
        if edit.kind in MACHINE:
            continue
        gap = edit.time - last.get(edit.author, float("-inf"))
        seconds = gap if 0 <= gap <= options.idle else options.first
        last[edit.author] = edit.time
        frames: tuple[int | None, ...] = edit.frames or (None,)
        for frame in frames:
            stroke = int(edit.kind in STROKES and frame is not None)
            found[frame, edit.author].add(Effort(seconds / len(frames), stroke, 1))
    return dict(found)
