"""A person who is followed, and the confidence in them."""

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
    """``fit`` mean cost of the cells; ``disputed`` share that are hardly less another's; ``size``
    and ``change`` number of cells over the most and over the last; ``shown`` share of the surface
    that nothing hides; ``like`` how like the clothes, a mean logarithm over the usual; ``back``
    whether nothing was seen in the frame before; ``touching`` share of the cells that touch
    another's, since a border through a body may be anywhere; ``wider`` metres by which they are
    spread along the ground more than one person is, since they may be those of two; ``astray`` how
    much farther they are from where they were expected than from where another was, a logarithm.
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
        """Compute the features that have weights, by name."""
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
        """0..1, of this frame by itself."""
        learnt = options.person_confidence
        odds = learnt.weights.odds(self.features(options)) + learnt.offset
        return squashed(odds)


@dataclass(eq=False)
class Identity:
    """Identity of a person, wherever they are: it goes along with a ``label``, less than 0 for who
    has none, when two have changed places.

    ``appearance`` their clothes, None where they were not seen; ``first`` the cells they came with;
    ``with_flying`` whether the flying pixels at their outline are theirs; ``stature`` how tall they
    are; ``confidence`` their last one; ``returned`` whether they left the picture since they were
    painted, so that they may be somebody else; ``doubts`` whom they may be as well, by label;
    ``sure`` the last frame in which they were surely themselves; ``colours`` (M, 3) those by which
    their clothes are told, and ``shown`` how much of them they are of, as ``Observation.area`` says
    it.
    """

    options: TrackerOptions
    label: int
    appearance: ColourHistogram | None
    first: float
    sure: int
    with_flying: bool = False
    stature: Stature = field(init=False)
    confidence: float = 1.0
    returned: bool = False
    doubts: set[int] = field(default_factory=set)
    colours: F32 = field(default_factory=lambda: np.empty((0, 3), np.float32))
    shown: float = 0.0

    def __post_init__(self) -> None:
        """Begin without a measured stature."""
        self.stature = Stature(self.options.stature)

    def show(self, colours: F32, area: float) -> None:
        """So much of them shows as never before: what they wear has also these ``colours`` (M,
        3)."""
        self.colours, self.shown = np.vstack([self.colours, colours]), area
        self.appearance = ColourHistogram.of(self.colours, self.options.appearance)


@dataclass(eq=False)
class Person:
    """An ``identity``; ``xyz`` (S, 3) and ``colour`` of their surface.

    ``since`` the frame they came in, ``back`` the one they came back in; ``step`` (3,) metres in
    the last frame, ``went`` (3,) since the start; ``size`` the most cells they had, ``last`` in the
    last frame; ``area`` the most that showed of them; ``spread`` how far along the ground they were
    where they were painted; ``at_side`` whether they touched a side of the picture when they were
    last seen; ``missing`` frames since they were seen; ``well`` the last in which more than scraps
    of them were, ``known`` (S, 3) their surface then; ``mistaken`` frames in which they and another
    were dressed as each other; ``ways`` (2,) along the ground up to each of the last frames, all of
    which show them.
    """

    options: TrackerOptions
    identity: Identity
    xyz: F64
    colour: F32
    since: int
    step: F64 = field(default_factory=lambda: np.zeros(3))
    went: F64 = field(default_factory=lambda: np.zeros(3))
    size: float = field(init=False)
    area: float = 0.0
    spread: float = 0.0
    last: int = field(init=False)
    age: int = 0
    at_side: bool = False
    frames_unseen: int = 0
    well: int = field(init=False)
    known: F64 = field(init=False)
    back: int = -(2**20)
    mistaken: int = 0
    ways: deque[F64] = field(init=False)

    def __post_init__(self) -> None:
        """Begin with the first cells as the most so far."""
        self.size, self.last = float(len(self.xyz)), len(self.xyz)
        self.well, self.known = self.since, self.xyz
        self.ways = deque(maxlen=self.options.body.way_frames)

    @staticmethod
    def met(
        options: TrackerOptions,
        label: int,
        xyz: F64,
        colour: F32,
        now: int,
        appearance: ColourHistogram | None = None,
    ) -> Person:
        """A person whose surface ``xyz`` (S, 3) and ``colour`` is first seen in frame ``now``."""
        return Person(
            options, Identity(options, label, appearance, float(len(xyz)), now), xyz, colour, now
        )

    @property
    def label(self) -> int:
        """Label of their points; less than 0 for people without one."""
        return self.identity.label

    @property
    def named(self) -> bool:
        """Whether they have a label."""
        return self.label > 0

    def elsewhere(self, observation: PersonObservation, now: int) -> bool:
        """Whether they may be where they were not expected: too little of them was there, or is."""
        return (
            self.well < now - 1
            or observation.area(observation.cells_of(self.label))
            < self.options.body.scrap_share * self.area
        )

    def likeness(self, colour: F32 | None) -> float:
        """Mean log likelihood of the colours (M, 3) by their clothes, over that of their own; 0
        without any."""
        appearance = self.identity.appearance
        if colour is None or appearance is None or not len(colour):
            return 0.0
        return appearance.likeness(colour) - appearance.usual

    def top(self, observation: PersonObservation) -> float | None:
        """Metres up to the top of what they have, where that is seen."""
        return top_of(observation, np.flatnonzero(observation.owner == self.label), self.area)

    def measure(self, top: float | None) -> None:
        """Take a top (m) that is surely their for how tall they are."""
        if top is not None:
            self.identity.stature.tops.append(top)

    def doubt(self, other: Person) -> None:
        """They may be the other, and the other they."""
        self.identity.doubts.add(other.label)
        other.identity.doubts.add(self.label)

    def become(self, other: Person) -> None:
        """Change places with another: each is themselves, where the other was thought to be."""
        apart = np.median(other.xyz, axis=0) - np.median(self.xyz, axis=0)
        self.went, other.went = other.went - apart, self.went + apart
        self.identity, other.identity = other.identity, self.identity
        self.ways.clear()
        other.ways.clear()
        self.mistaken = other.mistaken = 0

    def follow(self, observation: PersonObservation, step: F64, now: int) -> None:
        """Take in the cells they have in a frame, ``step`` (3,) metres on."""
        options = self.options.body
        cells = observation.cells_of(self.label)
        if len(cells) < max(options.seen_min_cells, options.seen_min_share * self.size):
            self._hide()
            return
        hidden = self._hidden(observation, cells, step)
        ground = observation.ground[cells]
        away = np.linalg.norm(ground - np.median(ground, axis=0), axis=1)
        # The median of what lies apart may be where nothing is.
        core = cells[np.linalg.norm(ground - ground[away.argmin()], axis=1) < options.memory_m]
        self.xyz = np.vstack([observation.cells.middle[core], (self.xyz + step)[hidden]])
        self.colour = np.vstack([observation.cells.colour[core], self.colour[hidden]])
        if self.frames_unseen:
            self.step, self.back = np.zeros(3), now
            long = self.frames_unseen > self.options.arrivals.missing_frames
            self.identity.returned |= self.at_side and long
        else:
            self.step = (
                step.copy()
                if self.age == 0
                else (1 - options.newest_step_weight) * self.step
                + options.newest_step_weight * step
            )
        self.went = self.went + step
        self.last = len(cells)
        self.size = max(options.most_decay * self.size, float(self.last))
        # Of what is no one, many cells may hold a few points each.
        area = observation.area(cells)
        self.area = max(options.most_decay * self.area, area)
        if area >= options.scrap_share * self.area:
            self.well, self.known = now, self.xyz
        self.frames_unseen, self.age = 0, self.age + 1
        self.at_side = observation.at_side(cells)
        self.ways.append(self.went @ observation.flat)

    def gone(self) -> tuple[int, float] | None:
        """Frames within which they have gone so far that all of them has moved, and how far (m)."""
        options = self.options.body
        for frames, way in enumerate(reversed(self.ways)):
            far = float(np.linalg.norm(way - self.ways[-1]))
            if frames >= options.gone_frames and far > options.gone_m:
                return frames, far
        return None

    def _hide(self) -> None:
        """Go on unseen, ever slower."""
        self.frames_unseen += 1
        self.last = 0
        self.ways.clear()
        self.xyz, self.went = self.xyz + self.step, self.went + self.step
        self.step = self.options.body.hidden_step_share * self.step

    def _hidden(self, observation: PersonObservation, cells: I64, step: F64) -> I64:
        """The cells of their surface that something hides now."""
        options = self.options.body
        if self.frames_unseen:
            return np.empty(0, np.int64)
        seen, there = observation.cells.middle[cells], self.xyz + step
        hides = observation.view.hides(there, options.memory_behind_m)
        apart = cKDTree(seen).query(there)[0] > options.memory_cells * observation.cells.size
        close = np.linalg.norm(there - np.median(seen, axis=0), axis=1) < options.memory_seen_m
        return np.flatnonzero(hides & apart & close)
