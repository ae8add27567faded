"""Who comes: bodies that nobody has are those who are missing, parts of who is there, or others.

Others are followed as well, without a label, so that no label goes over to them: who was there
while somebody was in sight is not him.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.figure import FEWEST, UNLIKE, Figure
from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.pieces import parts
from pointbrush.tracking.stage import Stage
from pointbrush.tracking.wardrobe import Wardrobe

SMALLEST, SHARE = 12, 0.12
"""Cells, and share of the usual number, from which a body may be somebody new."""
BACK, BACK_SHARE = 6, 0.05
"""The same, from which it may be somebody who was missing."""
WHOLE = 0.7
"""Share of what hangs together that must be nobody's."""
NEAR, FARTHER, LONG = 0.3, 0.2, 10
"""Metres from where somebody missing should be, more a frame, up to so many frames."""
CLOTHES, NAMELESS = 0.5, 0.5
"""Weight of clothes against the way, and what a body costs that was followed without a label."""
AROUND = 0.6
"""Metres along the ground around somebody in sight within which what comes into sight is his."""
JOINED, TOUCHES = 0.3, 0.1
"""Metres between bodies that come together without a label, and between one and who came back."""
JUST = 3
"""Frames within which somebody has just come."""


def come_back(stage: Stage, figures: Sequence[Figure], usual: float, now: int) -> set[int]:
    """Give bodies that nobody labelled had before to those who are missing, the likeliest first.

    Gives the numbers of those without a label who were one of them.
    """
    gone = [f for f in figures if f.named and f.elsewhere]
    offers = _offers(stage, figures, usual) if gone else []
    ranked = []
    for figure in gone:
        for number, (cells, other) in enumerate(offers):
            if other is not None and other.since <= now - max(figure.missing, figure.scraps):
                continue
            cost = _cost(stage, figure, cells, other)
            if cost is not None:
                ranked.append((cost, figure.label, number))
    found: set[int] = set()
    given: set[int] = set()
    gone_on: set[int] = set()
    young = [0, *(f.label for f in figures if not f.named and f.since > now - JUST)]
    for _, label, number in sorted(ranked):
        if label in found or number in given:
            continue
        found.add(label)
        given.add(number)
        cells, other = offers[number]
        if other is not None:
            gone_on.add(other.label)
        bodies = np.unique(stage.bodies[cells])
        whole = np.isin(stage.bodies, bodies[bodies >= 0]) & np.isin(stage.owner, young)
        stage.owner[stage.owner == label] = 0
        stage.owner[cells] = label
        stage.owner[whole] = label
        _back(figures, label)
    return gone_on


def _back(figures: Sequence[Figure], label: int) -> None:
    """Let a figure begin anew where it was found."""
    figure = next(f for f in figures if f.label == label)
    figure.missing = max(figure.missing, 1)


def _offers(
    stage: Stage, figures: Sequence[Figure], usual: float
) -> list[tuple[I64, Figure | None]]:
    """Cells of the bodies that may be somebody's who is missing, and whose they were."""
    part = parts(stage.cells.touching, (stage.owner == 0) & stage.cells.solid)
    count = np.bincount(part[part >= 0])
    large = np.flatnonzero(count >= max(BACK, BACK_SHARE * usual)).tolist()
    offers: list[tuple[I64, Figure | None]] = [(np.flatnonzero(part == n), None) for n in large]
    for figure in figures:
        cells = np.flatnonzero(stage.owner == figure.label)
        if not figure.named and not figure.missing and len(cells):
            offers.append((cells, figure))
    return offers


def _cost(stage: Stage, figure: Figure, cells: I64, other: Figure | None) -> float | None:
    """How unlikely a body is somebody missing; None where it cannot be he."""
    reach = NEAR + FARTHER * min(figure.missing, LONG)
    gap = _least(figure.xyz + figure.step, stage.cells.middle[cells])
    like = figure.likeness(stage.some(cells))
    if gap > reach or like < -UNLIKE:
        return None
    nameless = NAMELESS if stage.tints is None and other is not None else 0.0
    return gap / reach - CLOTHES * like + nameless


def newcomers(stage: Stage, figures: Sequence[Figure], usual: float, now: int) -> list[Figure]:
    """Who else has come; what comes into sight around somebody is his."""
    free = (stage.owner == 0) & stage.cells.solid
    bodies = stage.bodies
    fresh: list[Figure] = []
    lowest = min([0, *(f.label for f in figures)])
    for number in np.unique(bodies[free]).tolist():
        cells = np.flatnonzero((bodies == number) & free)
        whole = np.count_nonzero(bodies == number)
        if len(cells) < max(FEWEST, WHOLE * whole):
            continue
        owner = _whose(stage, figures, cells) if now else None
        if owner is None and len(cells) >= max(SMALLEST, SHARE * usual):
            owner = _beside(stage, [*figures, *fresh], cells)
            if owner is None:
                owner = lowest - 1 - len(fresh)
                some = stage.some(cells)
                worn = None if some is None else Wardrobe.of(some)
                middle, colour = stage.cells.middle[cells], stage.cells.colour[cells]
                fresh.append(Figure(owner, middle, colour, now, worn))
        stage.owner[cells] = owner or 0
    return fresh


def _whose(stage: Stage, figures: Sequence[Figure], cells: I64) -> int | None:
    """The label of who is in sight around a body, and not dressed otherwise."""
    middle = np.median(stage.ground[cells], axis=0)
    best, nearest = None, AROUND
    for figure in figures:
        own = stage.owner == figure.label
        if figure.named and own.any():
            known = np.vstack([stage.ground[own], (figure.xyz + figure.step) @ stage.flat])
            away = float(np.linalg.norm(np.median(known, axis=0) - middle))
            if away < nearest:
                best, nearest = figure, away
    if best is None or best.likeness(stage.some(cells)) < -UNLIKE:
        return None
    return best.label


def _beside(stage: Stage, figures: Sequence[Figure], cells: I64) -> int | None:
    """The number of who has no label and is right beside a body."""
    for figure in figures:
        own = stage.owner == figure.label
        if not figure.named and own.any() and _gap(stage, own.nonzero()[0], cells) < JOINED:
            return figure.label
    return None


def merge(stage: Stage, figures: Sequence[Figure], now: int) -> set[int]:
    """The numbers of those who have just come, and are parts of somebody just come back."""
    gone: set[int] = set()
    returned = [f for f in figures if f.named and f.age and now - f.back <= JUST]
    for figure in figures:
        cells = np.flatnonzero(stage.owner == figure.label)
        if figure.named or now - figure.since > JUST or figure.missing or not len(cells):
            continue
        for other in returned:
            own = np.flatnonzero(stage.owner == other.label)
            if len(own) and _gap(stage, own, cells) < TOUCHES:
                stage.owner[cells] = other.label
                gone.add(figure.label)
                break
    return gone


def _gap(stage: Stage, one: I64, other: I64) -> float:
    """Metres between two bodies."""
    return _least(stage.cells.middle[one], stage.cells.middle[other])


def _least(one: F64, other: F64) -> float:
    gap, _ = cKDTree(one).query(other)
    return float(np.min(gap))
