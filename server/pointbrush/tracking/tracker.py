"""`auto`: joint tracking of objects as moving surfaces, through occlusions.

``Run.step`` is the method: observe, predict, register, associate, label, judge, manage, learn.
Each step is a module of steps/.  The static scene is in scene/, the state of a track in model/, the
joint tracking of people in people/, and every tunable number in options/.
Source: docs/tracking.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import chain

import numpy as np

from pointbrush.tracking.compute.grid import within
from pointbrush.tracking.compute.rigid import inverse, transform, transform_each
from pointbrush.tracking.conflicts import bodies_left, look_for, settle_conflicts
from pointbrush.tracking.explanation import Watch, explain
from pointbrush.tracking.interface import (
    F32,
    F64,
    I64,
    FrameKnowledge,
    FrameResult,
    Frames,
    Known,
    Seed,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.bodies import entering_bodies, keep_connected
from pointbrush.tracking.people.group import JointTracking
from pointbrush.tracking.permissions import FEWEST, Companions, FrameRules
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations
from pointbrush.tracking.steps.claim import together
from pointbrush.tracking.steps.context import (
    set_other_movers_around,
    store_other_movers,
    update_distinct_colours,
)
from pointbrush.tracking.steps.ground_contact import with_ground
from pointbrush.tracking.steps.grow import grow
from pointbrush.tracking.steps.identity import Swaps
from pointbrush.tracking.steps.predict import Search, crop, share_out
from pointbrush.tracking.steps.relocate import find_astray, register_and_claim
from pointbrush.tracking.steps.results import (
    FrameAssociations,
    FrameClaims,
    FrameOutcomes,
    FrameTask,
)
from pointbrush.tracking.steps.settle import Outcome, settle
from pointbrush.tracking.steps.smooth import Held, Smoother
from pointbrush.tracking.steps.update import (
    begin_label,
    correct_track,
    positions_to_exclude,
    restart_track,
)


@dataclass(frozen=True)
class AutoTracker:
    """The default method; ``watch`` gets the steps for each label in each frame."""

    watch: Watch | None = None
    options: TrackerOptions = field(default_factory=TrackerOptions)

    def track(
        self,
        frames: Frames,
        order: Sequence[int],
        seeds: Sequence[Seed],
        known: Known,
        options: TrackOptions,
    ) -> Iterator[FrameResult]:
        """See ``Method.track``."""
        started = _before(seeds, known(options.before[0])) if options.before else list(seeds)
        run = Run(frames, [*options.before, *order], started, known, options, self)
        with closing(run.scene):
            if options.before:
                run.recall(started)
                given = {seed.label: np.sort(seed.indices) for seed in seeds}
                first = run.step(order[0], given).result
            else:
                first = run.start(seeds)
            back = {n: inverse(state.pose) for n, state in first.tracks.items()}
            first = replace(first, assignments={})
            for result in chain([first], run.through(order[1:])):
                requested = run.companions.without(result)
                yield run.scene.since(requested, back, order[0])


class Run:
    """The state of one run."""

    def __init__(
        self,
        frames: Frames,
        order: list[int],
        seeds: list[Seed],
        known: Known,
        track_options: TrackOptions,
        method: AutoTracker | None = None,
    ) -> None:
        """``seeds``: labels in the first frame of ``order``."""
        method = method or AutoTracker()
        self.options = method.options
        self._watch, self._near = method.watch, method.options.companions
        self.known, self.track_options, self.labels = known, track_options, [s.label for s in seeds]
        self.swaps = Swaps(self.options.identity)
        self.tracks: dict[int, Track] = {}
        self.astray: dict[int, int] = {}
        self.aside: frozenset[int] = frozenset()
        """Labels not tracked in the last frame, as their points there were stored."""
        self.people = JointTracking(self.tracks, self.options, track_options)
        first = frames(order[0]).xyz
        rules = FrameRules(len(first), known(order[0]), track_options)
        self.companions = Companions(seeds, rules, first, self._near)
        labelled = [*seeds, *self.companions.beginning]
        painted = np.concatenate([_EMPTY, *(seed.indices for seed in labelled)])
        self.scene = Scene(
            frames,
            order,
            self._reach,
            painted,
            options=self.options,
            known=track_options.sensor,
            ahead=track_options.read_ahead,
        )

    @property
    def background(self) -> Background:
        """Background model of the static scene."""
        return self.scene.background

    def _reach(self, world: F32) -> F32:
        options = self.options.track
        units = [t.unit for t in self.tracks.values()] or [options.default_unit_m]
        return np.full(len(world), options.static_units * float(np.median(units)), np.float32)

    def start(self, seeds: Sequence[Seed]) -> FrameResult:
        """Start with the painted seeds and the companions."""
        view = self.scene.first
        # The order of labels must not depend on the request.
        seeds = sorted([*seeds, *self.companions.beginning], key=lambda seed: seed.label)
        view.labels = {seed.label: np.sort(seed.indices) for seed in seeds}
        for seed in seeds:
            self._begin(view, seed.label, np.sort(seed.indices))
        update_distinct_colours(self.tracks, view, self.tracks)
        self.scene.learn_first(survey=any(track.large for track in self.tracks.values()))
        self.people.gather(view, self.background, self.tracks)
        view.people = self.people.labels
        for track in (t for n, t in self.tracks.items() if view.people and n not in view.people):
            set_other_movers_around(track, view, track.model.xyz)
        states = {s.label: TrackState.painted(len(s.indices), np.eye(4)) for s in seeds}
        return FrameResult(view.number, {}, states)

    def _begin(self, view: View, label: int, points: I64) -> None:
        begin_label(self.tracks, view, label, points, self.scene.noise(view, points))
        self.astray.pop(label, None)

    def recall(self, seeds: Sequence[Seed]) -> None:
        """Process the frames before the start, from the labels in the first of them."""
        self.start([seed for seed in seeds if len(seed.indices) >= FEWEST])
        for number in self.track_options.before[1:]:
            self.step(number)

    def through(self, order: Sequence[int]) -> Iterator[FrameResult]:
        """Yield the results of the following frames, smoothed with a fixed lag."""
        smoother = Smoother(self.track_options, self.options.smoothing)
        for number in order:
            new = self.step(number)
            smoother.relabel(self.people.pop_recognised())
            yield from smoother.take(new, self.tracks, self.background, self.people.pending)
        yield from smoother.flush()

    def step(self, number: int, given: Mapping[int, I64] | None = None) -> Held:
        """Track all labels into the next frame; ``given``: known points by label."""
        frame = self._observe(number, given or {})
        searches = self._predict(frame)
        associated = self._associate(frame, self._register(frame, searches))
        claims = self._label(associated)
        outcomes = self._judge(frame, associated, claims)
        states = self._manage(frame, associated, outcomes)
        return self._learn(frame, associated, claims, states)

    def _observe(self, number: int, given: Mapping[int, I64]) -> FrameTask:
        """Read a frame, and determine its known and free points."""
        view = self.scene.view(number)
        view.people = self.people.labels
        rules = FrameRules(len(view.xyz), self.known(number), self.track_options)
        fixed = {n: k for n in self.tracks if (k := rules.keyframe(n)) is not None}
        fixed |= self.companions.known(rules, view.xyz, self.tracks)
        fixed |= given
        aside = self._set_aside(view, rules, fixed)
        free = rules.free(self.labels)
        for points in chain(fixed.values(), aside.values()):
            free[points] = False
        sought = [t for n, t in self.tracks.items() if not (n in fixed or n in self.people)]
        return FrameTask(view, rules, fixed, aside, free, sought)

    def _predict(self, frame: FrameTask) -> dict[int, Search]:
        """Crop the frame around the predicted poses of each visible track."""
        there = [track for track in frame.sought if not (track.absent or track.lost)]
        cut = {t.label: crop(t, frame.view, self.background, frame.free) for t in there}
        searches = {label: search for label, search in cut.items() if search is not None}
        return share_out(searches, options=self.options.search)

    def _register(self, frame: FrameTask, searches: Mapping[int, Search]) -> Associations:
        """Register each track to its part of the frame, and claim points for it."""
        found = {n: register_and_claim(self.tracks[n], frame.view, s) for n, s in searches.items()}
        return Associations(frame.view, self.background, frame.free, found)

    def _associate(self, frame: FrameTask, registered: Associations) -> FrameAssociations:
        """Resolve conflicting claims, and search for lost tracks and for large occluded ones."""
        settled = settle_conflicts(self.tracks, registered)
        settled = find_astray(frame.sought, self.astray, settled)
        caps = self.swaps.meet(self.tracks, settled.registrations)
        absent = [track for track in frame.sought if track.absent]
        associations, hidden = look_for(absent, self.tracks, settled)
        return FrameAssociations(associations, caps, hidden)

    def _label(self, associated: FrameAssociations) -> FrameClaims:
        """Extend each track's claim to new surface and connected points."""
        associations = associated.associations
        grown = grow(self.tracks, associations)
        labelled = grown.labelled
        labelled |= keep_connected(self.tracks, associations, labelled, grown.taken)
        emerged = bodies_left(associated.hidden, self.tracks, associations, labelled)
        emerged |= entering_bodies(self.tracks, associations, labelled)
        return FrameClaims(labelled, emerged)

    def _judge(
        self, frame: FrameTask, associated: FrameAssociations, claims: FrameClaims
    ) -> FrameOutcomes:
        """Judge and update each track; people are tracked jointly in the remaining points."""
        outcomes: dict[int, Outcome] = {}
        for track in frame.sought:
            n = track.label
            if not (track.lost or n in claims.emerged):
                found, given = associated.associations.found.get(n), claims.labelled.get(n)
                cap = associated.caps.get(n, 1.0)
                outcomes[n] = settle(track, frame.view, found, given, self.track_options, cap)
        left = frame.free.copy()
        for points in chain((each.points for each in outcomes.values()), claims.emerged.values()):
            left[points] = False
        outcomes |= self.people.step(frame.view, self.background, left, frame.fixed)
        self.people.update_carriers(frame.view, outcomes)
        return FrameOutcomes(outcomes, claims.emerged)

    def _manage(
        self, frame: FrameTask, associated: FrameAssociations, outcomes: FrameOutcomes
    ) -> dict[int, TrackState]:
        """Determine the state of each track, and start tracks of labels painted in this frame."""
        view = frame.view
        view.labels = frame.fixed | frame.aside
        states = self._conclude(view, frame.rules, frame.fixed, outcomes)
        for label in frame.fixed.keys() - self.tracks.keys():
            self._begin(view, label, frame.fixed[label])
            states[label] = TrackState.painted(len(frame.fixed[label]), np.eye(4))
            update_distinct_colours(self.tracks, view, [label])
            self.people.join(view, self.background, label)
        if self._watch is not None:
            fits = associated.associations.registrations
            for label in self.labels:
                if label in states:
                    track, fit, state = self.tracks[label], fits.get(label), states[label]
                    self._watch(explain(view, self.background, track, fit, state))
        return states

    def _learn(
        self,
        frame: FrameTask,
        associated: FrameAssociations,
        claims: FrameClaims,
        states: dict[int, TrackState],
    ) -> Held:
        """Update the background and each track's surroundings; return the frame's result."""
        view, fits = frame.view, associated.associations.registrations
        store_other_movers(self.tracks, view, associated.associations, claims.labelled)
        self.background.learn(view, keep=positions_to_exclude(self.tracks, fits, view))
        found = with_ground(view, self.tracks, fits, frame.free)
        found = {n: points for n, points in found.items() if n in states}
        states |= {n: replace(states[n], points=len(points)) for n, points in found.items()}
        return Held(view, frame.free, FrameResult(view.number, found, states), associated.caps)

    def _set_aside(self, view: View, rules: FrameRules, fixed: dict[int, I64]) -> dict[int, I64]:
        """Return stored points by label of companions far from the requested labels.

        They keep these points and are not tracked.  Companions that come near are restarted from
        their stored points, in ``fixed``.
        """
        aside: dict[int, I64] = {}
        stored = self.companions.stored(rules, view.xyz)
        requested = [self.tracks[n] for n in self.labels if n in self.tracks] if stored else []
        regions = [self._region(track) for track in requested]
        for label, points in stored.items():
            if label in fixed or label in self.people:
                continue
            step = max(1, len(points) // self._near.sampled_points)
            some = view.xyz[points[::step]].astype(np.float64)
            if any(_meets(some, expected, margin) for expected, margin in regions):
                if label in self.aside:
                    fixed[label] = points
                continue
            aside[label] = points
            if self.tracks.pop(label, None) is not None:
                self.swaps.forget(label)
                self.astray.pop(label, None)
        self.aside = frozenset(aside)
        return aside

    def _region(self, track: Track) -> tuple[F64, float]:
        """Return the expected points (M, 3) of a label, and the margin (m) it may move by."""
        near = self._near
        xyz = track.model.xyz[:: max(1, len(track.model.xyz) // near.sampled_points)]
        expected = transform_each(track.motion.predictions, xyz).reshape(-1, 3)
        margin = near.near_radii * track.span + near.near_units * track.unit
        return expected, margin + near.near_steps * track.motion.speed * track.motion.gap

    def _conclude(
        self, view: View, rules: FrameRules, fixed: Mapping[int, I64], outcomes: FrameOutcomes
    ) -> dict[int, TrackState]:
        """Return the state of each track, and write its points to ``view.labels``."""
        states: dict[int, TrackState] = {}
        for label, track in self.tracks.items():
            if label in fixed:
                states[label] = self._repainted(track, view, fixed[label])
                self.people.join(view, self.background, label)
            elif label in outcomes.emerged:
                states[label] = self._emerge(track, view, outcomes.emerged[label])
                view.labels[label] = outcomes.emerged[label]
                self.people.join(view, self.background, label)
            elif label in outcomes.settled:
                states[label] = outcomes.settled[label].state
                points = together(outcomes.settled[label].points, rules.anchors(label))
                if len(points) and states[label].state != "lost":
                    view.labels[label] = points
                    states[label] = replace(states[label], points=len(points))
        return states

    def _repainted(self, track: Track, view: View, points: I64) -> TrackState:
        """Update a track from painted points, or restart it if its model does not fit them."""
        self.swaps.forget(track.label)
        pose = None if track.label in self.people else correct_track(track, view, points)
        if pose is None:
            return self._begin_anew(track, view, points)
        world = transform(pose, track.model.xyz)
        set_other_movers_around(track, view, world)
        return TrackState.painted(len(points), pose)

    def _begin_anew(self, track: Track, view: View, points: I64) -> TrackState:
        noise = self.scene.noise(view, points)
        pose = restart_track(self.tracks, view, track.label, points, noise)
        self.astray.pop(track.label, None)
        return TrackState.painted(len(points), pose)

    def _emerge(self, track: Track, view: View, points: I64) -> TrackState:
        """Restart a large object from its reappeared part, or an entering one as a body."""
        options = self.options.track
        state = self._begin_anew(track, view, points)
        renewed = self.tracks[track.label]
        renewed.confidence = options.emerged_confidence
        if track.large:
            renewed.extent, renewed.size, renewed.appearance = (
                track.span,
                track.size,
                track.appearance,
            )
        return replace(state, confidence=options.emerged_confidence, state="tracked")


def _meets(some: F64, expected: F64, margin: float) -> bool:
    """Return whether some of the points (N, 3) lie within ``margin`` metres of others."""
    lo, hi = expected.min(axis=0) - margin, expected.max(axis=0) + margin
    some = some[within(some, lo, hi)]
    if not len(some):
        return False
    square = ((some[:, None] - expected) ** 2).sum(axis=2)
    return bool(square.min() <= margin**2)


_EMPTY: I64 = np.empty(0, np.int64)


def _before(seeds: Sequence[Seed], known: FrameKnowledge | None) -> list[Seed]:
    """Return the seeds with their points in another frame, empty if its labels are unknown."""
    if known is None:
        return [Seed(seed.label, _EMPTY) for seed in seeds]
    label = np.where(known.deleted, 0, known.label)
    return [Seed(seed.label, np.flatnonzero(label == seed.label)) for seed in seeds]
