"""Order of frames by their times if plausible, otherwise by the order of files or records."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

log = logging.getLogger(__name__)
SET_BACK = 3
"""Weight of a step back in time, in irregular steps: clocks are seldom set back."""
RENUMBERED = 3
"""Weight of sorting against a numbered order, in irregular steps."""
FEW = 3
"""Number of frames that is too small for a comparison of two orders."""
LEAST_STEP = 1e-4
"""Seconds; least plausible step of frames with counts of nanoseconds in their names."""

MILLI = 3
"""Digits of a count of milliseconds."""
MICRO = 6
"""Digits of a count of microseconds."""
NANO = 9
"""Digits of a count of nanoseconds."""


@dataclass(frozen=True, slots=True)
class TimeOrder:
    """Places of frames in the order of the recording.

    ``source`` describes the reason for the order, ``times`` the source of the times, "" for none.
    """

    places: Sequence[int]
    source: str
    times: str = ""


def order_by_time(
    times: Sequence[float],
    source: str,
    given: str,
    *,
    where: str = "",
    numbered: bool | None = True,
) -> TimeOrder:
    """Return the order by ``times`` (seconds) if its steps are plausible, else the given one.

    ``source`` describes the times, of ``where``, and ``given`` the order of the frames, which is
    evidence if it is ``numbered``; None if only the times give an order.  Warnings report equal
    times, and times that decrease in an order that is evidence.
    """
    steps = np.diff(np.asarray(times, np.float64))
    equal, back = int((steps == 0).sum()), np.flatnonzero(steps < 0)
    named = f"{where}{source}"
    if equal:
        log.warning(
            "%s: %d of %d times are equal to the time before; frames of one time are ordered %s",
            named, equal, len(times), given,
        )  # fmt: skip
    places = sorted(range(len(times)), key=times.__getitem__)
    sorts = numbered is None or _is_plausible(places, times, len(back), numbered)
    if len(back) and (numbered or not sorts):
        log.warning(
            "%s: ordered %s, the times go back %d times, first by %.6g s before frame %d; the "
            "frames are %s", named, given, len(back), -steps[back[0]], back[0] + 1,
            "sorted by time" if sorts else "not sorted by time, as their steps would not be even",
        )  # fmt: skip
    if sorts:
        return TimeOrder(places, f"by {source}", source)
    return TimeOrder(range(len(times)), f"{given} (the times go back: {source})", source)


def _is_plausible(places: Sequence[int], times: Sequence[float], back: int, numbered: bool) -> bool:
    """Return whether sorting explains the times better than a clock that was set ``back``."""
    uneven = irregular_steps([times[place] for place in places])
    if not back or len(times) <= FEW:
        return not back or uneven == 0
    against = RENUMBERED if numbered else 0
    return uneven + against < irregular_steps(times) + (SET_BACK - 1) * back


def irregular_steps(times: Sequence[float]) -> int:
    """Count the steps that are not half to one and a half times the usual step."""
    steps = np.diff(np.asarray(times, np.float64))
    forward = steps[steps > 0]
    if not len(forward):
        return len(steps)
    usual = np.quantile(forward, 0.5, method="lower")
    return int(((steps < usual / 2) | (steps > usual * 1.5)).sum())


def read_fractions(wholes: Sequence[str], fractions: Sequence[str]) -> list[Decimal]:
    """Return the values of numbers that are written with a whole part and a fraction.

    A fraction is decimal, or a count of micro- or nanoseconds that its writer did not pad:
    ``1600000000.5000000`` of ROS's ``pointcloud_to_pcd`` is 5 ms after the second.  It is a count
    if the fractions have several lengths, none begins with 0, and the steps are more even so.
    """
    pairs = list(zip(wholes, fractions, strict=True))
    decimals = [Decimal(f"{whole}.{fraction or 0}") for whole, fraction in pairs]
    longest = max(map(len, fractions), default=0)
    unpadded = all(part == "0" or (part and part[0] != "0") for part in fractions)
    if not unpadded or not MILLI < longest <= NANO or len(set(map(len, fractions))) < 2:
        return decimals
    unit = 10 ** (NANO if longest > MICRO else MICRO)
    counts = [int(whole) + Decimal(fraction) / unit for whole, fraction in pairs]
    as_decimals, as_counts = (_since_first(values) for values in (decimals, counts))
    if float(np.median(np.diff(as_counts))) < LEAST_STEP:
        return decimals
    # No writer of decimals of several lengths keeps zeros at their end.
    sure = longest == NANO or any(len(part) > 1 and part[-1] == "0" for part in fractions)
    fewer = irregular_steps(as_counts) - irregular_steps(as_decimals)
    return counts if fewer < 0 or (fewer == 0 and sure) else decimals


def _since_first(values: Sequence[Decimal]) -> list[float]:
    """Return the values in their order, less the first: as floats they keep their differences."""
    ordered = sorted(values)
    return [float(value - ordered[0]) for value in ordered]
