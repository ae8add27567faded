"""Presence of all viewers: the newest place of each, relayed at a bounded rate."""

from __future__ import annotations

from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode

COLORS = ("#e4572e", "#17bebb", "#ffc914", "#76b041", "#a06cd5", "#f06bb2", "#4f9dff", "#d98f4e")
RELAYS_PER_SECOND = 20_000
"""Presence messages a second that the server relays at most, over all viewers."""


def color_of(viewer: str) -> str:
    """Return the default colour of a viewer."""
    return COLORS[int(viewer[:8], 16) % len(COLORS)]


class Presence:
    """Newest presence by sequence and viewer."""

    def __init__(self) -> None:
        self._changed: dict[str, dict[str, bytes]] = {}
        self._last: dict[tuple[str, str], messages.ServerPresence] = {}

    def put(self, sequence: str, presence: messages.ServerPresence) -> None:
        """Store the new place of a viewer."""
        self._last[sequence, presence.viewer] = presence
        self._changed.setdefault(sequence, {})[presence.viewer] = encode(presence)

    def take_changes(self) -> dict[str, dict[str, bytes]]:
        """Remove and return the changes since the last call."""
        changed, self._changed = self._changed, {}
        return changed

    def messages_in(self, sequence: str) -> dict[str, bytes]:
        """Return the presence messages of all viewers of a sequence, for a new viewer."""
        return {who: encode(last) for (where, who), last in self._last.items() if where == sequence}

    def remove(self, viewer: str, sequence: str) -> bytes | None:
        """Remove a viewer; return the message for the others if they had its place."""
        last = self._last.pop((sequence, viewer), None)
        self._changed.get(sequence, {}).pop(viewer, None)
        return None if last is None else encode(last.model_copy(update={"left": True}))

    @staticmethod
    def pause(viewers: int, most_per_second: float) -> float:
        """Return the seconds between relays; each relay sends ``viewers`` squared messages."""
        return max(1.0 / most_per_second, viewers * viewers / RELAYS_PER_SECOND)
