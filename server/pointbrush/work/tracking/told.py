"""A tracking run's outcome in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pointbrush.tracking import FrameResult
from pointbrush.work.tracking.job import doubtful

MOST_NAMED = 4
"""Labels that are told of one by one; of those beyond only their number."""


def counted(results: Iterable[FrameResult], start: int, names: Mapping[int, str]) -> str:
    """Return in how many frames each label was found, and in how many that is doubtful.

    As "pin 1: 29 frames, 7 doubtful; pin 2: 29 frames"; ``start``, which was painted, is left out.
    """
    found: dict[int, int] = {}
    doubts: dict[int, int] = {}
    for result in results:
        if result.frame == start:
            continue
        for label, track in result.tracks.items():
            found[label] = found.get(label, 0) + (track.points > 0)
            doubts[label] = doubts.get(label, 0) + doubtful(track)
    said = [_one(names.get(label, str(label)), found[label], doubts[label]) for label in found]
    if len(said) > MOST_NAMED:
        rest = list(found)[MOST_NAMED:]
        more = f"{len(rest)} more labels, {sum(doubts[label] for label in rest)} frames doubtful"
        said[MOST_NAMED:] = [more]
    return "; ".join(said)


def _one(name: str, frames: int, doubtful_frames: int) -> str:
    told = f"{name}: {frames} {'frame' if frames == 1 else 'frames'}"
    return f"{told}, {doubtful_frames} doubtful" if doubtful_frames else told
