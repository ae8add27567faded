"""The finding of a check, and the thresholds of checks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import median
from typing import get_args

from pointbrush.values.team.review import Finding, FindingKind

Kind = FindingKind
KINDS: tuple[Kind, ...] = get_args(get_args(Kind)[0])


def finding(
    kind: Kind,
    text: str,
    labels: tuple[int, ...] = (),
    first: int | None = None,
    last: int | None = None,
    place: tuple[float, float, float] | None = None,
) -> Finding:
    """Return a finding with an id that is unique in the recording and stable over checks."""
    identifier = "-".join(map(str, (kind, *labels, first, last)))
    return Finding(identifier, kind, text, labels, first, last, place, settled=False)


def grouped(found: Iterable[Finding]) -> list[Finding]:
    """Join findings of one kind and label in consecutive frames, with the text of the first."""
    runs: list[Finding] = []
    for each in sorted(found, key=lambda one: (one.kind, one.labels, one.first or 0)):
        before = runs[-1] if runs else None
        if (
            before is not None
            and (before.kind, before.labels) == (each.kind, each.labels)
            and before.last is not None
            and each.first == before.last + 1
        ):
            runs[-1] = finding(
                before.kind, before.text, before.labels, before.first, each.last, before.place
            )
        else:
            runs.append(each)
    return runs


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """Thresholds of the checks; raises ValueError for one that is not above 0.

    ``few_points``    a label with at most so many points in a frame was painted by mistake.
    ``sample``        limit of points of a label that are checked in a frame.
    ``link``          largest distance within a piece, metres, independent of density.
    ``spacing``       the same, as a multiple of the median distance to the nearest point.
    ``stray``         distance from a label's largest piece at which another piece is stray, metres,
    ``stray_extent``  or this share of that piece's diagonal, if it is more.
    ``jump``          distance between two frames that is a jump, metres,
    ``jump_factor``   if it is also so many times the label's median step around there.
    ``window``        number of neighbouring frames on either side.
    ``share``         a label with less than this share of its neighbours' points, or so much
                      more, is unlike them.
    ``sizable``       points below which a label's count is not checked.
    ``unsure``        minimum share of a label's predicted points in a frame with a confidence,
                      0 to 255, below ``least_sure``.
    ``returned``      minimum number of doubtful frames after a label is found again.
    ``gap``           longest run of frames without a label between frames that have it.
    ``box_turn``      implausible rotation between two frames, degrees.
    ``box_size``      allowed difference of a side between boxes of one label, as a share.
    ``box_overlap``   allowed share of the smaller box's volume inside another box.
    ``box_hang``      allowed distance of a box's underside from the ground, metres.
    ``ground_round``  width of the surroundings of a box used for its ground, metres.
    ``box_margin``    margin of a box within which points count as inside, metres,
    ``box_outside``   and the allowed share of a label's points outside.
    """

    few_points: int = 5
    sample: int = 4000
    link: float = 0.1
    spacing: float = 4.0
    stray: float = 0.5
    stray_extent: float = 0.5
    jump: float = 0.3
    jump_factor: float = 4.0
    window: int = 3
    share: float = 0.3
    sizable: int = 30
    unsure: float = 0.2
    least_sure: int = 100
    returned: int = 4
    gap: int = 3
    box_turn: float = 60.0
    box_size: float = 0.1
    box_overlap: float = 0.1
    box_hang: float = 0.3
    ground_round: float = 1.0
    box_margin: float = 0.1
    box_outside: float = 0.1


def usual_step(steps: Mapping[int, float], frame: int, window: int) -> float:
    """Return the median step, metres, to frames within ``window`` frames of one; 0 without any."""
    others = [step for n, step in steps.items() if 0 < abs(n - frame) <= window]
    return median(others) if others else 0.0
