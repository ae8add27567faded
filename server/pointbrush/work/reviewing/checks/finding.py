"""A finding of a check, and the thresholds from which something is suspicious."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Literal, get_args

Kind = Literal[
    "name", "category", "few", "stray", "jump", "unlike", "predicted",
    "box_jump", "box_size", "box_overlap", "box_ground", "box_empty", "box_outside",
    "box_heading",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
"""Two labels of one name; labels without a category; a label of few points; points far from their
object; a track that jumps; a frame unlike its neighbours; points that a classifier labelled without
being sure.  A box that jumps or turns about; boxes of one label and two sizes; that share volume;
off the ground; without points; points of a label outside its box; a box whose front is unknown."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious thing.

    ``labels``         the labels that it is about; () where it is about frames.
    ``first``, ``last``  its frames, both included; None where it is about the palette.
    ``place``          where to look in frame ``first``, source coordinates in metres, or None.
    ``settled``        a reviewer has accepted it: the frames, or the label, unchanged since.
    """

    kind: Kind
    text: str
    labels: tuple[int, ...] = ()
    first: int | None = None
    last: int | None = None
    place: tuple[float, float, float] | None = None
    settled: bool = False

    @property
    def id(self) -> str:
        """Tells this finding from the others of its recording, however often one looks."""
        return "-".join(map(str, (self.kind, *self.labels, self.first, self.last)))


def grouped(found: Iterable[Finding]) -> list[Finding]:
    """Join findings of one kind and label in consecutive frames; the first one's words stay."""
    runs: list[Finding] = []
    for each in sorted(found, key=lambda one: (one.kind, one.labels, one.first or 0)):
        before = runs[-1] if runs else None
        if (
            before is not None
            and (before.kind, before.labels) == (each.kind, each.labels)
            and before.last is not None
            and each.first == before.last + 1
        ):
            runs[-1] = replace(before, last=each.last)
        else:
            runs.append(each)
    return runs


@dataclass(frozen=True, slots=True)
class CheckOptions:
    """Numbers of the checks; raises ValueError for one that is not above 0.

    ``few_points``    a label with at most so many points in a frame is a slip of the brush.
    ``sample``        points of a label that are looked at in a frame.
    ``link``          metres: points no farther apart belong together, whatever their density.
    ``spacing``       the same, as a multiple of the median distance to the nearest point.
    ``stray``         metres from the largest piece of a label at which another piece is far off,
    ``stray_extent``  or this share of that piece's diagonal, whichever is more.
    ``jump``          metres between two frames that are a jump,
    ``jump_factor``   if they are also so many times the label's median step near there.
    ``window``        frames to either side that are neighbours.
    ``share``         a label with less than this share of its neighbours' points, or so much
                      more, is unlike them.
    ``sizable``       points below which a label's count may do what it likes.
    ``unsure``        share of a label's predicted points in a frame from which on somebody should
                      look, when their confidence, 0 to 255, is below ``least_sure``.
    ``gap``           frames that a label may be missing from between two that have it.
    ``box_turn``      degrees between two frames that no object turns by.
    ``box_size``      share by which boxes of one label may differ in a side.
    ``box_overlap``   share of the smaller box's volume that another one may share.
    ``box_hang``      metres from the ground that a box's underside may be.
    ``ground_round``  metres round a box where its ground is looked for.
    ``box_margin``    metres beyond a box that points still count as inside,
    ``box_outside``   and the share of a label's points that may lie outside.
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
    gap: int = 3
    box_turn: float = 60.0
    box_size: float = 0.1
    box_overlap: float = 0.1
    box_hang: float = 0.3
    ground_round: float = 1.0
    box_margin: float = 0.1
    box_outside: float = 0.1

    def __post_init__(self) -> None:
        for field in fields(self):
            if not getattr(self, field.name) > 0:
                raise ValueError(f"{field.name}: expected more than 0")
