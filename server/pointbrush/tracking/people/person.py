"""A tracked person and their confidence."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.interface import F32, F64, I64
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import log_ratio, squashed
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.stature import Stature, top_of


@dataclass(frozen=True, slots=True)
class PersonEvidence:
    """Features of a person's cells in a frame.

    ``fit``: mean cost; ``disputed``: share with a nearly equal cost for another person; ``size``
    and ``change``: number over the maximum and over the last frame's; ``shown``: visible share of
    the surface; ``like``: mean log likelihood of clothes over the usual one; ``back``: unseen in
    the last frame; ``touching``: share that touches another person, because a border through a body
    is uncertain; ``wider``: metres of spread on the ground beyond one person's, a sign of two
    people; ``astray``: log ratio of the distances from the expected and another's position.
    """

    fit: float
    disputed: float
    size: float
    change: float
    shown: float
    like: float
    back: bool
    touching: float
    wider: float
    astray: float

    def features(self, options: TrackerOptions) -> dict[str, float]:
        """Return the features with weights, by name."""
        limits = options.confidence
        return {
            "fit": self.fit,
            "disputed": self.disputed,
            "size": abs(log_ratio(self.size, options.person_confidence.max_log_size)),
            "change": abs(log_ratio(self.change, limits.max_log_change)),
            "like": max(min(self.like, 0.0), limits.min_log_clothes),
            "back": float(self.back),
            "touching": self.touching,
            "wider": self.wider,
            "astray": self.astray,
        }

    def likelihood(self, options: TrackerOptions) -> float:
        """Return the likelihood, 0 to 1, of this frame alone."""
        learnt = options.person_confidence
        odds = learnt.weights.odds(self.features(options)) + learnt.offset
        return squashed(odds)


@dataclass(eq=False)
class Identity:
    """Identity of a person, which moves with the label when two people are exchanged.

    ``label``: below 0 for unlabelled people; ``appearance``: their clothes, None if unseen;
    ``first``: number of cells at the start; ``with_flying``: whether flying pixels at the outline
    are theirs; ``cap``: maximum confidence, as they left the picture since they were painted and
    may be another person; ``doubts``: labels of people they may be instead; ``sure``: last frame
    with a certain identity; ``colours`` (M, 3): samples of ``appearance``; ``shown``: visible
    surface of these, see ``PersonObservation.area``.
    """

    options: TrackerOptions
    label: int
    appearance: ColourHistogram | None
    first: float
    sure: int
    with_flying: bool = False
    stature: Stature = field(init=False)
    confidence: float = 1.0
    cap: float = 1.0
    doubts: set[int] = field(default_factory=set)
    colours: F32 = field(default_factory=lambda: np.empty((0, 3), np.float32))
    shown: float = 0.0

    def __post_init__(self) -> None:
        """Start without a measured stature."""
        self.stature = Stature(self.options.stature)

    def show(self, colours: F32, area: float) -> None:
        """Add ``colours`` (M, 3) of the largest visible surface so far to their clothes."""
        self.colours, self.shown = np.vstack([self.colours, colours]), area
        self.appearance = ColourHistogram.of(self.colours, self.options.appearance)


@dataclass(eq=False)
class Person:
    """An ``identity`` with the surface ``xyz`` (S, 3) and its ``colour``.

    ``since``: first frame; ``reappearance``: frame of the last reappearance; ``step`` (3,): metres
    in the last frame; ``displacement`` (3,): metres since the start; ``size``: maximum number of
    cells; ``last``: their number in the last frame; ``area``: maximum visible surface; ``spread``:
    spread on the ground (m) when painted; ``at_side``: whether they touched a side of the picture
    when last seen, or since ``last_clear``; ``last_clear``: last frame with more than scraps of
    them; ``known`` (S, 3): their surface in it; ``exchanged_frames``: consecutive frames with
    clothes exchanged with another person; ``positions`` (2,): on the ground, in the last frames;
    ``seen``: points (M,) by frame of a newcomer who may be recognised later, then of the person.
    """

    options: TrackerOptions
    identity: Identity
    xyz: F64
    colour: F32
    since: int
    step: F64 = field(default_factory=lambda: np.zeros(3))
    displacement: F64 = field(default_factory=lambda: np.zeros(3))
    size: float = field(init=False)
    area: float = 0.0
    spread: float = 0.0
    last: int = field(init=False)
    age: int = 0
    at_side: bool = False
    frames_unseen: int = 0
    last_clear: int = field(init=False)
    known: F64 = field(init=False)
    reappearance: int = -(2**20)
    exchanged_frames: int = 0
    positions: deque[F64] = field(init=False)
    seen: dict[int, I64] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Start with the first cells as the maximum."""
        self.size, self.last = float(len(self.xyz)), len(self.xyz)
        self.last_clear, self.known = self.since, self.xyz
        self.positions = deque(maxlen=self.options.body.way_frames)

    @staticmethod
    def first_seen(
        options: TrackerOptions,
        label: int,
        xyz: F64,
        colour: F32,
        now: int,
        appearance: ColourHistogram | None = None,
    ) -> Person:
        """Return a person with the surface ``xyz`` (S, 3), ``colour`` first seen in ``now``."""
        return Person(
            options, Identity(options, label, appearance, float(len(xyz)), now), xyz, colour, now
        )

    @property
    def label(self) -> int:
        """Label of their points; below 0 for unlabelled people."""
        return self.identity.label

    @property
    def named(self) -> bool:
        """Whether they have a label of the run."""
        return self.label > 0

    def may_be_elsewhere(self, observation: PersonObservation, now: int) -> bool:
        """Return whether they may be at an unexpected place, as too little of them is visible."""
        return (
            self.last_clear < now - 1
            or observation.area(observation.cells_of(self.label))
            < self.options.body.scrap_share * self.area
        )

    def has_left(self, now: int) -> bool:
        """Return whether they left at a side of the picture, since only scraps are visible."""
        return self.at_side and self.last_clear < now - 1

    def likeness(self, colour: F32 | None) -> float:
        """Return the mean log likelihood of colours (M, 3) for their clothes over the usual one.

        It is 0 without colours.
        """
        appearance = self.identity.appearance
        if colour is None or appearance is None or not len(colour):
            return 0.0
        return appearance.likeness(colour) - appearance.usual

    def top(self, observation: PersonObservation) -> float | None:
        """Return the height (m) of the top of their cells; None if it is not visible."""
        return top_of(observation, np.flatnonzero(observation.owner == self.label), self.area)

    def measure(self, top: float | None) -> None:
        """Add a measured top (m) to their stature; None: ignored."""
        if top is not None:
            self.identity.stature.tops.append(top)

    def doubt(self, other: Person) -> None:
        """Record that the two people may be exchanged."""
        self.identity.doubts.add(other.label)
        other.identity.doubts.add(self.label)

    def exchange_identity(self, other: Person) -> None:
        """Exchange identities with another person."""
        apart = np.median(other.xyz, axis=0) - np.median(self.xyz, axis=0)
        self.displacement, other.displacement = (
            other.displacement - apart,
            self.displacement + apart,
        )
        self.identity, other.identity = other.identity, self.identity
        self.positions.clear()
        other.positions.clear()
        self.exchanged_frames = other.exchanged_frames = 0

    def follow(self, observation: PersonObservation, step: F64, now: int) -> None:
        """Update the person from their cells in a frame, after a ``step`` (3,) in metres."""
        options = self.options.body
        cells = observation.cells_of(self.label)
        if len(cells) < max(options.seen_min_cells, options.seen_min_share * self.size):
            self._hide()
            return
        hidden = self._hidden(observation, cells, step)
        ground = observation.ground[cells]
        distance = np.linalg.norm(ground - np.median(ground, axis=0), axis=1)
        # The median of separate parts may lie in empty space; use the cell closest to it.
        core = cells[np.linalg.norm(ground - ground[distance.argmin()], axis=1) < options.memory_m]
        self.xyz = np.vstack([observation.cells.middle[core], (self.xyz + step)[hidden]])
        self.colour = np.vstack([observation.cells.colour[core], self.colour[hidden]])
        if self.frames_unseen:
            self.step, self.reappearance = np.zeros(3), now
        else:
            self.step = (
                step.copy()
                if self.age == 0
                else (1 - options.newest_step_weight) * self.step
                + options.newest_step_weight * step
            )
        self.displacement = self.displacement + step
        self.last = len(cells)
        self.size = max(options.most_decay * self.size, float(self.last))
        # Cells without surface of a person may be many, with a few points each.
        area = observation.area(cells)
        self.area = max(options.most_decay * self.area, area)
        if area >= options.scrap_share * self.area:
            if self.has_left(now - self.options.arrivals.missing_frames):
                self.identity.cap = min(self.identity.cap, options.doubted_confidence)
            self.last_clear, self.known = now, self.xyz
        self.frames_unseen, self.age = 0, self.age + 1
        self.at_side = observation.at_side(cells) or self.has_left(now)
        self.positions.append(self.displacement @ observation.flat)

    def departure(self) -> tuple[int, float] | None:
        """Return the frames and distance (m) in which all of them moved; None: they did not."""
        options = self.options.body
        for frames, way in enumerate(reversed(self.positions)):
            far = float(np.linalg.norm(way - self.positions[-1]))
            if frames >= options.gone_frames and far > options.gone_m:
                return frames, far
        return None

    def _hide(self) -> None:
        """Predict the person while occluded, with decreasing speed."""
        self.frames_unseen += 1
        self.last = 0
        self.positions.clear()
        self.xyz, self.displacement = self.xyz + self.step, self.displacement + self.step
        self.step = self.options.body.hidden_step_share * self.step

    def _hidden(self, observation: PersonObservation, cells: I64, step: F64) -> I64:
        """Return the indices of their surface that are occluded now."""
        options = self.options.body
        if self.frames_unseen:
            return np.empty(0, np.int64)
        seen, there = observation.cells.middle[cells], self.xyz + step
        hides = observation.view.hides(there, options.memory_behind_m)
        apart = cKDTree(seen).query(there)[0] > options.memory_cells * observation.cells.size
        close = np.linalg.norm(there - np.median(seen, axis=0), axis=1) < options.memory_seen_m
        return np.flatnonzero(hides & apart & close)
