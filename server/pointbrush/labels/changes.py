"""Changes of points by an edit, place by place: in memory while it is little, packed when it grows.

An edit of a whole scan is 24 bytes a point in the form it is worked with.  Beyond a few million
points the places not touched for longest are kept as the journal will hold them, which is a byte
or two a point where labels are mixed, and next to nothing where they are not.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator, Mapping

from pointbrush.labels.blocks import Place
from pointbrush.labels.packing import Change, decode_change, encode_change

OPEN_POINTS = 4_000_000
"""Points whose changes are kept unpacked, 24 bytes each."""


class Changes(Mapping[Place, Change]):
    """Changes by place, in the order of places; ``put`` adds or replaces one."""

    def __init__(self, packed: Mapping[Place, bytes] | None = None) -> None:
        """``packed``: what the journal holds of an edit."""
        self._packed: dict[Place, bytes] = dict(packed or {})
        self._open: OrderedDict[Place, Change] = OrderedDict()
        self._points = 0

    def __getitem__(self, place: Place) -> Change:
        change = self._open.get(place)
        return decode_change(self._packed[place]) if change is None else change

    def __contains__(self, place: object) -> bool:
        return place in self._open or place in self._packed

    def __iter__(self) -> Iterator[Place]:
        return iter(sorted(self._open.keys() | self._packed.keys()))

    def __len__(self) -> int:
        return len(self._open) + len(self._packed)

    def put(self, place: Place, change: Change) -> None:
        """Set what is done to a place."""
        self._packed.pop(place, None)
        earlier = self._open.pop(place, None)
        self._points += len(change.indices) - (0 if earlier is None else len(earlier.indices))
        self._open[place] = change
        while self._points > OPEN_POINTS and len(self._open) > 1:
            oldest, old = self._open.popitem(last=False)
            self._points -= len(old.indices)
            self._packed[oldest] = encode_change(old)

    def packed(self, place: Place) -> bytes:
        """A place's change as the journal holds it."""
        change = self._open.get(place)
        return self._packed[place] if change is None else encode_change(change)

    def clear(self) -> None:
        """Forget everything."""
        self._packed.clear()
        self._open.clear()
        self._points = 0
