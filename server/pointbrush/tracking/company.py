"""People before a depth camera at rest, all at once, with those who have no label.

What moves before the known scene is shared out among all who are there: each is expected where the
depth image shows him (strides.py); cells go to who is near and dressed alike, and agree with those
that they touch (claimants.py); who was hidden, and who is new, is among what is left (comers.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pointbrush.tracking.background import Background
from pointbrush.tracking.claimants import BEFORE, CAP, Shares, shared_out
from pointbrush.tracking.comers import come_back, merge, mistakable, newcomers
from pointbrush.tracking.confidence import REGAIN
from pointbrush.tracking.figure import Figure
from pointbrush.tracking.figures import CELL, FINE
from pointbrush.tracking.foreground import Foreground
from pointbrush.tracking.interface import F64, I64, Mask, TrackState
from pointbrush.tracking.looks import Looks
from pointbrush.tracking.settle import PATIENCE
from pointbrush.tracking.stage import Stage, across
from pointbrush.tracking.strides import strides
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

FORGOTTEN = 5
"""Frames unseen after which who has no label is forgotten."""
GROWN, LIKE = 1.3, 0.7
"""Times as many cells as people have that are too many for one, and how much less like his clothes
what he has may be to be his without doubt."""
DOUBTED = 0.4
"""Confidence of what may be another's at most."""


@dataclass(eq=False)
class Company:
    """Everybody there, in cells of ``size`` metres; ``flat`` (3, 2) is the ground."""

    figures: list[Figure]
    size: float
    flat: F64
    usual: float
    now: int = 0

    @staticmethod
    def of(view: View, things: Mapping[int, Thing], background: Background) -> Company:
        """The painted people ``things`` of a first frame, and who else is there."""
        sizes = [max(CELL * thing.unit, FINE * thing.span) for thing in things.values()]
        people = {label: view.xyz[view.labels[label]].astype(np.float64) for label in things}
        company = Company([], float(np.median(sizes)), across(view, people.values()), 0.0)
        stage = company._stage(view, background, np.ones(len(view.xyz), np.bool_))
        for label, thing in things.items():
            company.put(view, label, thing)
            inside = np.isin(stage.cells.indices, view.labels[label])
            stage.owner[np.unique(stage.cells.cell[inside])] = label
        company.usual = float(np.median([figure.size for figure in company.figures]))
        company.figures += newcomers(stage, company.figures, company.usual, 0)
        return company

    @property
    def labels(self) -> set[int]:
        """Whom a person painted."""
        return {figure.label for figure in self.figures if figure.named}

    def _stage(self, view: View, background: Background, free: Mask) -> Stage:
        return Stage.of(view, background, free, self.size, self.flat)

    def put(self, view: View, label: int, thing: Thing) -> None:
        """Somebody is where he was painted in a frame, whatever was thought of him."""
        if not len(view.labels[label]):
            return
        cells = Foreground.of(view, view.labels[label], self.size)
        figure = Figure(label, cells.middle, cells.colour, self.now, thing.worn)
        figure.went = thing.motion.poses[-1][:3, 3]
        self.drop(label)
        self.figures = sorted([*self.figures, figure], key=lambda f: -f.label)

    def drop(self, label: int) -> None:
        """Look for somebody no more."""
        self.figures = [f for f in self.figures if f.label != label]

    def step(
        self, view: View, background: Background, free: Mask
    ) -> dict[int, tuple[TrackState, I64]]:
        """Who has which of the ``free`` points (N,) of the next frame."""
        self.now += 1
        stage = self._stage(view, background, free)
        figures = self.figures
        shares = None
        if len(stage.owner) and figures:
            shares = shared_out(stage, figures, strides(stage, figures))
            gone = come_back(stage, figures, self.usual, self.now)
            fresh = newcomers(stage, figures, self.usual, self.now)
            gone |= merge(stage, [*figures, *fresh], self.now)
            self.figures = [f for f in [*figures, *fresh] if f.label not in gone]
        found = {}
        for k, figure in enumerate(figures):
            stride = figure.step if shares is None else shares.stride[k]
            looks = _looks(stage, figure, shares, k, stride)
            if looks is not None and figure.named:
                self.doubt(stage, figure, looks)
            figure.follow(stage, stride, self.now)
            if figure.named:
                found[figure.label] = _state(stage, figure, looks)
        self.figures = [f for f in self.figures if f.named or f.missing < FORGOTTEN]
        return found

    def doubt(self, stage: Stage, figure: Figure, looks: Looks) -> None:
        """Doubt who is found again, or much larger, where another may be; and on, until his
        clothes tell."""
        other = mistakable(stage, self.figures, figure, self.now)
        most = GROWN * max(figure.first, self.usual)
        if other and (figure.missing > 0 or looks.size * figure.size > most):
            figure.doubted = True
        elif not other and stage.tints is not None and looks.like > -LIKE:
            figure.doubted = False


def _looks(
    stage: Stage, figure: Figure, shares: Shares | None, k: int, stride: F64
) -> Looks | None:
    """What somebody's share of a frame says about itself; None where there is none."""
    cells = np.flatnonzero((stage.owner == figure.label) & stage.cells.solid)
    if shares is None or not len(cells):
        return None
    at, depth = stage.view.project(figure.xyz + stride)
    shown = (stage.view.depth[at] > depth - BEFORE) & (at >= 0)
    return Looks(
        fit=float(np.minimum(shares.cost[cells, k], CAP).mean()),
        disputed=shares.disputed(cells, k),
        size=len(cells) / max(figure.size, 1.0),
        change=len(cells) / max(figure.last, 1),
        shown=float(shown.mean()),
        like=figure.likeness(stage.some(cells)),
        back=figure.missing > 0,
    )


def _state(stage: Stage, figure: Figure, looks: Looks | None) -> tuple[TrackState, I64]:
    """How somebody fared, and his points."""
    pose = np.eye(4)
    pose[:3, 3] = figure.went
    points = stage.cells.indices[stage.owner[stage.cells.cell] == figure.label]
    if figure.missing or looks is None:
        figure.trust = max(0.0, figure.trust - REGAIN)
        lost = figure.missing > PATIENCE
        state = TrackState(pose, 0.0, 0.0, 0.0, 0, "lost" if lost else "occluded")
        return state, points[:0]
    figure.trust = min(looks.likelihood(), figure.trust + REGAIN)
    if figure.doubted:
        figure.trust = min(figure.trust, DOUBTED)
    state = TrackState(pose, 0.0, looks.shown, figure.trust, len(points), "tracked")
    return state, np.sort(points)
