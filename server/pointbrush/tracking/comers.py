"""Who comes: bodies that nobody has are those who are missing, parts of who is there, or others.

Others are followed as well, without a label, so that no label goes over to them: who was there
while somebody was in sight is not him.  Of two who come out from behind each other as one body, one
may have both: what he has in the clothes of the other is looked for too.
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
AWHILE, PART, RATHER = 3, 0.2, 0.7
"""Frames missing, share of the usual number, and how much more like his clothes, in the mean
logarithm, from which a part of another is his."""
WHOLE = 0.7
"""Share of what hangs together that must be nobody's."""
NEAR, FARTHER, LONG = 0.3, 0.2, 10
"""Metres from where somebody missing should be, more a frame, up to so many frames."""
CLOTHES, NAMELESS = 0.5, 0.5
"""Weight of clothes against the way, and what a body costs that was followed without a label."""
TOLD = 0.3
"""How much more like his clothes than another's what somebody has is certainly not the other's."""
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
    gone = [f for f in figures if f.named and f.elsewhere(stage, now)]
    offers = _offers(stage, figures, gone, usual, now) if gone else []
    ranked = []
    for figure in gone:
        for number, (cells, other) in enumerate(offers):
            if not _may_be(figure, other):
                continue
            cost = _cost(stage, figure, cells, other, now)
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
        taken = np.zeros(len(stage.owner), np.bool_)
        taken[cells] = True
        if other is None or not other.named:
            bodies = np.unique(stage.bodies[cells])
            taken |= np.isin(stage.bodies, bodies[bodies >= 0]) & np.isin(stage.owner, young)
        if other is not None and not other.named:
            gone_on.add(other.label)
        stage.owner[stage.owner == label] = 0
        stage.owner[taken] = label
        _back(figures, label)
    return gone_on


def _may_be(figure: Figure, other: Figure | None) -> bool:
    """Whether what is nobody's, or an ``other``'s, may be somebody's who is missing: who has no
    label and was there while he was in sight is not he."""
    if other is None or other.named:
        return other is not figure
    return other.since > figure.well


def _back(figures: Sequence[Figure], label: int) -> None:
    """Let a figure begin anew where it was found."""
    figure = next(f for f in figures if f.label == label)
    figure.missing = max(figure.missing, 1)


def _offers(
    stage: Stage, figures: Sequence[Figure], gone: Sequence[Figure], usual: float, now: int
) -> list[tuple[I64, Figure | None]]:
    """Cells that may be somebody's who is ``gone``, and whose they were."""
    part = parts(stage.cells.touching, (stage.owner == 0) & stage.cells.solid)
    count = np.bincount(part[part >= 0])
    large = np.flatnonzero(count >= max(BACK, BACK_SHARE * usual)).tolist()
    offers: list[tuple[I64, Figure | None]] = [(np.flatnonzero(part == n), None) for n in large]
    for figure in figures:
        cells = np.flatnonzero(stage.owner == figure.label)
        if not figure.named and not figure.missing and len(cells):
            offers.append((cells, figure))
    if stage.tints is not None:
        for figure in (f for f in gone if f.well < now - AWHILE):
            offers += _dressed_as(stage, figures, figure, usual)
    return offers


def _dressed_as(
    stage: Stage, figures: Sequence[Figure], who: Figure, usual: float
) -> list[tuple[I64, Figure | None]]:
    """What others have and is dressed as somebody who is missing, rather than as they are."""
    if who.worn is None:
        return []
    found: list[tuple[I64, Figure | None]] = []
    his = stage.unlike(who.worn)
    for other in figures:
        if other is who or not other.named or other.worn is None:
            continue
        mask = (stage.owner == other.label) & stage.cells.solid
        mask &= stage.smooth(stage.unlike(other.worn) - his) > RATHER
        part = parts(stage.cells.touching, mask)
        count = np.bincount(part[part >= 0])
        large = np.flatnonzero(count >= max(BACK, PART * usual)).tolist()
        found += [(np.flatnonzero(part == n), other) for n in large]
    return found


def _cost(stage: Stage, figure: Figure, cells: I64, other: Figure | None, now: int) -> float | None:
    """How unlikely a body is somebody missing; None where it cannot be he."""
    away = far_from(stage, figure, cells, now)
    like = figure.likeness(stage.some(cells))
    if away > 1.0 or like < -UNLIKE:
        return None
    nameless = NAMELESS if stage.tints is None and other is not None else 0.0
    return away - CLOTHES * like + nameless


def far_from(stage: Stage, figure: Figure, cells: I64, now: int) -> float:
    """Share of the way that somebody missing may have gone at which a body is."""
    there = np.vstack([figure.xyz + figure.step, figure.known])
    reach = NEAR + FARTHER * min(max(now - 1 - figure.well, 0), LONG)
    return _least(there, stage.cells.middle[cells]) / reach


def mistakable(stage: Stage, figures: Sequence[Figure], figure: Figure, now: int) -> bool:
    """Whether what somebody has may as well be another's, who is missing near it."""
    cells = stage.cells_of(figure.label)
    some = stage.some(cells)
    like = figure.likeness(some)
    rivals = [f for f in figures if f.named and f is not figure and f.elsewhere(stage, now)]
    rivals = [f for f in rivals if some is None or like - f.likeness(some) < TOLD]
    return len(cells) > 0 and any(far_from(stage, f, cells, now) < 1.0 for f in rivals)


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
