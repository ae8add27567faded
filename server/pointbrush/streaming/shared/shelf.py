"""Frames that somebody looks at, kept open for all rooms of a server."""

from __future__ import annotations

import sys
from collections import OrderedDict
from dataclasses import dataclass

from pointbrush.sequences import StoredFrame
from pointbrush.streaming.table import FrameTable

MOST_FRAMES, LEAST_FRAMES = 4096, 16
FILES_SHARE = 8
"""Of the files that this process may open, one in so many is for mapped frames at most."""

Key = tuple[str, int]
"""A recording's identity and a frame's number."""


@dataclass(slots=True)
class OpenFrame:
    """A frame and its levels; ``looked_at``: its bytes have been read since it was opened.

    ``depth``: the levels of its depth image, those of its points where it has none.
    """

    stored: StoredFrame
    table: FrameTable
    depth: FrameTable
    looked_at: bool = False


class Shelf:
    """The most recently used frames, as many as there are files to spare.  Event loop only.

    A frame is a few kilobytes and a mapped file: its bytes stay the page cache's.
    """

    def __init__(self, limit: int | None = None) -> None:
        """``limit``: frames that are kept; by default what the process's limit of files allows."""
        self._limit = most_frames() if limit is None else limit
        self._frames: OrderedDict[Key, OpenFrame] = OrderedDict()

    def __len__(self) -> int:
        return len(self._frames)

    def get(self, key: Key) -> OpenFrame | None:
        """A frame, if it is here."""
        found = self._frames.get(key)
        if found is not None:
            self._frames.move_to_end(key)
        return found

    def put(self, key: Key, frame: OpenFrame) -> OpenFrame:
        """Keep a frame, and return the one that is kept under its key."""
        kept = self._frames.setdefault(key, frame)
        while len(self._frames) > self._limit:
            self._frames.popitem(last=False)
        return kept

    def forget(self, identity: str) -> None:
        """Let go of a recording's frames: nobody looks at it any more."""
        for key in [key for key in self._frames if key[0] == identity]:
            del self._frames[key]


def most_frames() -> int:
    """Frames that may be kept open in this process."""
    if sys.platform == "win32":
        return MOST_FRAMES
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    files = MOST_FRAMES * FILES_SHARE if soft == resource.RLIM_INFINITY else soft
    return max(LEAST_FRAMES, min(MOST_FRAMES, files // FILES_SHARE))
