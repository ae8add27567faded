"""Timetable of throws: hands, pins and moments.

A siteswap is a list of throws, one per beat, repeated; hands take turns.  With two jugglers the
hands' order is right, right, left, left of persons 1, 2, 1, 2 ("four-handed siteswap", Boyce and
Simpson), so odd throws are passes.  A throw of as many beats as there are hands stays in the hand.
"""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.errors import BadInputError


@dataclass(frozen=True, slots=True)
class Rhythm:
    """A siteswap, the number of hands, seconds per beat and seconds a pin stays in a hand."""

    throws: tuple[int, ...]
    hands: int
    beat: float
    dwell: float

    @property
    def pins(self) -> int:
        """Number of pins that the siteswap keeps up."""
        return sum(self.throws) // len(self.throws)


@dataclass(frozen=True, slots=True)
class Throw:
    """One flight: pin and hands by number from 0, times in seconds."""

    pin: int
    hand: int
    leave: float
    to_hand: int
    arrive: float


def rhythm(siteswap: str, hands: int, beat: float, dwell: float) -> Rhythm:
    """Parse a siteswap of digits and letters ("774", "b97").

    Raises BadInputError when two throws would land at the same time.
    """
    try:
        throws = tuple(int(c, 36) for c in siteswap)
    except ValueError:
        throws = ()
    n = len(throws)
    if n == 0 or len({(i + t) % n for i, t in enumerate(throws)}) != n:
        raise BadInputError(f"pattern: expected a valid siteswap like '774', got {siteswap!r}")
    if any(0 < t != hands and t * beat <= dwell + 0.1 for t in throws):
        raise BadInputError(f"pattern: expected throws with time to fly, got {siteswap!r}")
    return Rhythm(throws, hands, beat, dwell)


def schedule(rhythm: Rhythm, start: float, stop: float) -> list[Throw]:
    """All throws that matter to start..stop, in order of leaving."""
    longest = max(rhythm.throws)
    first = int(start / rhythm.beat) - 3 * longest - rhythm.hands
    last = int(stop / rhythm.beat) + 2 * longest + rhythm.hands
    first -= first % (len(rhythm.throws) * rhythm.hands)
    landing: dict[int, int] = {}
    throws: list[Throw] = []
    pins = 0
    for beat in range(first, last):
        height = rhythm.throws[beat % len(rhythm.throws)]
        if height == 0:
            continue
        pin = landing.pop(beat, None)
        if pin is None:
            pin, pins = pins, pins + 1
        landing[beat + height] = pin
        hand, to_hand = beat % rhythm.hands, (beat + height) % rhythm.hands
        if height != rhythm.hands:
            arrive = (beat + height) * rhythm.beat - rhythm.dwell
            throws.append(Throw(pin, hand, beat * rhythm.beat, to_hand, arrive))
    return throws
