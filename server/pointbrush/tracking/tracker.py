"""`auto`: every object as a surface that moves, is hidden and comes back; all at once.

In each frame: predict where each object is (objects/motion.py), register its model there in place
and colour (fitting/, geometry/registration.py) to what did not stand still (background/), bend it
where it is not rigid (geometry/deformation.py), let all objects claim points together against what
is known to be unlabelled (segmentation/), judge the fit by what the sensor should have seen
(fitting/judge.py), and learn (update/): the background, the model, the motion.  People are
followed together (people/).
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
    Mask,
    Seed,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.parallel.workers import Workers
from pointbrush.tracking.people.bodies import hang_together
from pointbrush.tracking.people.group import JointTracking
from pointbrush.tracking.permissions import FEWEST, Companions, FrameRules
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.begin import begin_anew, begin_label, corrected
from pointbrush.tracking.steps.claim import Claim, Findings, together
from pointbrush.tracking.steps.context import note_beside, set_other_movers_around, tell_apart
from pointbrush.tracking.steps.grow import grow
from pointbrush.tracking.steps.identity import Swaps
from pointbrush.tracking.steps.pieces import with_ground
from pointbrush.tracking.steps.predict import crop, share_out
from pointbrush.tracking.steps.relocate import find_astray, placed
from pointbrush.tracking.steps.settle import settle
from pointbrush.tracking.steps.smooth import Held, Smoother
from pointbrush.tracking.steps.update import withheld


@dataclass(frozen=True)
class AutoTracker:
    """The default method; ``watch`` gets how each label was found in each frame, in one process."""

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
        begun = _before(seeds, known(options.before[0])) if options.before else list(seeds)
        if self.watch is not None:
            options = replace(options, processes=1)
        with Workers(frames if options.processes > 1 else None) as workers:
            run = Run(frames, [*options.before, *order], begun, known, options, workers, self)
            with closing(run.scene):
                if options.before:
                    run.recall(begun)
                    given = {seed.label: np.sort(seed.indices) for seed in seeds}
                    first = run.step(order[0], given).result
                else:
                    first = run.start(seeds)
                back = {n: inverse(state.pose) for n, state in first.tracks.items()}
                first = replace(first, assignments={})
                for result in chain([first], run.through(order[1:])):
                    asked = run.companions.without(result)
                    yield run.scene.since(asked, back, order[0])


class Run:
    """The state of one run."""

    def __init__(
        self,
        frames: Frames,
        order: list[int],
        seeds: list[Seed],
        known: Known,
        asked: TrackOptions,
        workers: Workers,
        method: AutoTracker | None = None,
    ) -> None:
        """``seeds`` of the first frame of ``order``."""
        method = method or AutoTracker()
        self.options = method.options
        self._watch, self._near = method.watch, method.options.companions
        self.known, self.asked, self.labels = known, asked, [s.label for s in seeds]
        self.workers, self.swaps = workers, Swaps(self.options)
        self.tracks: dict[int, Track] = {}
        self.astray: dict[int, int] = {}
        self.aside: frozenset[int] = frozenset()
        """Labels that were not followed in the last frame: their points there were known."""
        self.people = JointTracking(self.tracks, self.options, continue_lost=asked.continue_lost)
        first = frames(order[0]).xyz
        rules = FrameRules(len(first), known(order[0]), asked)
        self.companions = Companions(seeds, rules, first, self._near)
        labelled = [*seeds, *self.companions.beginning]
        painted = np.concatenate([_EMPTY, *(seed.indices for seed in labelled)])
        self.scene = Scene(
            frames, order, self._reach, painted, options=self.options, ahead=asked.processes > 1
        )

    @property
    def background(self) -> Background:
        """Return what is known of the scene that stands still."""
        return self.scene.background

    def _reach(self, world: F32) -> F32:
        options = self.options.track
        units = [t.unit for t in self.tracks.values()] or [options.default_unit_m]
        return np.full(len(world), options.static_units * float(np.median(units)), np.float32)

    def start(self, seeds: Sequence[Seed]) -> FrameResult:
        """Begin with a person's points, and those of who goes along."""
        view = self.scene.first
        # Whoever is asked for, all are found in the same order.
        seeds = sorted([*seeds, *self.companions.beginning], key=lambda seed: seed.label)
        view.labels = {seed.label: np.sort(seed.indices) for seed in seeds}
        for seed in seeds:
            self._begin(view, seed.label, np.sort(seed.indices))
        tell_apart(self.tracks, view, self.tracks)
        self.scene.learn_first(survey=any(track.large for track in self.tracks.values()))
        self.people.gather(view, self.background, self.tracks)
        states = {s.label: _painted(len(s.indices), np.eye(4)) for s in seeds}
        return FrameResult(view.number, {}, states)

    def _begin(self, view: View, label: int, points: I64) -> None:
        begin_label(self.tracks, view, label, points, self.scene.noise(view, points))
        self.astray.pop(label, None)

    def recall(self, seeds: Sequence[Seed]) -> None:
        """Go through the frames before the start, from what is labelled in the first of them."""
        self.start([seed for seed in seeds if len(seed.indices) >= FEWEST])
        for number in self.asked.before[1:]:
            self.step(number)

    def through(self, order: Sequence[int]) -> Iterator[FrameResult]:
        """Find everything in the frames that follow, and what was in doubt once it is known."""
        smoother = Smoother(self.asked, self.options)
        for number in order:
            yield from smoother.take(self.step(number), self.tracks, self.background)
        yield from smoother.rest()

    def step(self, number: int, given: Mapping[int, I64] | None = None) -> Held:
        """Find everything in the next frame; ``given`` labels' points are known."""
        view, tracks = self.scene.view(number), self.tracks
        self.workers.show(view, self.background)
        rules = FrameRules(len(view.xyz), self.known(number), self.asked)
        fixed = {n: k for n in tracks if (k := rules.keyframe(n)) is not None}
        fixed |= self.companions.known(rules, view.xyz, tracks)
        fixed |= given or {}
        aside = self._set_aside(view, rules, fixed)
        free = rules.free(self.labels)
        for points in chain(fixed.values(), aside.values()):
            free[points] = False
        sought = [t for n, t in tracks.items() if not (n in fixed or n in self.people)]
        absent = [track for track in sought if track.absent]
        findings = self._find([t for t in sought if not t.absent], view, free)
        fits = findings.fits
        settle_conflicts(tracks, findings)
        find_astray(sought, self.astray, findings)
        self.swaps.meet(tracks, fits)
        loose = look_for(absent, tracks, findings)
        settled, emerged = self._settle(sought, findings, loose)
        left = free.copy()
        for _, points in settled.values():
            left[points] = False
        settled |= self.people.step(view, self.background, left, fixed)
        view.labels = fixed | aside
        states = self._conclude(view, rules, fixed, emerged, settled)
        for label in fixed.keys() - tracks.keys():
            self._begin(view, label, fixed[label])
            states[label] = _painted(len(fixed[label]), np.eye(4))
            tell_apart(self.tracks, view, [label])
            self.people.join(view, self.background, label)
        if self._watch is not None:
            for label in self.labels:
                if label in states:
                    fit, state = fits.get(label), states[label]
                    self._watch(explain(view, self.background, tracks[label], fit, state))
        note_beside(tracks, view, fits)
        self.workers.learn(view, self.background, withheld(tracks, fits, view))
        found = with_ground(view, tracks, fits, free)
        found = {n: points for n, points in found.items() if n in states}
        states |= {n: replace(states[n], points=len(points)) for n, points in found.items()}
        most = {n: fit.most for n, fit in fits.items()}
        return Held(view, free, FrameResult(number, found, states), most)

    def _set_aside(self, view: View, rules: FrameRules, fixed: dict[int, I64]) -> dict[int, I64]:
        """Labels that are not asked for, and whose stored points are far from what is: they have
        these, and are not followed.  Those that come near are begun anew from them, in ``fixed``.
        """
        regions = [self._region(self.tracks[n]) for n in self.labels if n in self.tracks]
        aside: dict[int, I64] = {}
        for label, points in self.companions.stored(rules, view.xyz).items():
            if label in fixed or label in self.people:
                continue
            step = max(1, len(points) // self._near.sampled_points)
            some = view.xyz[points[::step]].astype(np.float64)
            if any(_meets(some, fits, margin) for fits, margin in regions):
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
        """Points (M, 3) of where a label is expected, and metres around them that it may take."""
        near = self._near
        xyz = track.model.xyz[:: max(1, len(track.model.xyz) // near.sampled_points)]
        fits = transform_each(track.motion.predictions(), xyz).reshape(-1, 3)
        margin = near.near_radii * track.span + near.near_units * track.unit
        return fits, margin + near.near_steps * track.motion.speed * track.motion.gap

    def _find(self, tracks: list[Track], view: View, free: Mask) -> Findings:
        """Return where objects are that were seen the last time, and what each would have there."""
        there = [track for track in tracks if not track.lost]
        predicted = None  # where objects are looked for
        known, here = (self.background, free, predicted), not self.workers.learns
        cut = self.workers.each(crop, there, lambda _: known, here=here)
        searches = {label: search for label, search in cut.items() if search is not None}
        share_out(list(searches.values()), options=self.options.search)
        there = [self.tracks[label] for label in searches]
        found = self.workers.each(placed, there, lambda track: (searches[track.label],))
        findings = Findings(view, self.background, free)
        for label, (fit, claim) in found.items():
            findings.put(label, fit, claim)
        return findings

    def _settle(
        self, sought: list[Track], findings: Findings, loose: Mapping[int, I64]
    ) -> tuple[dict[int, tuple[TrackState, I64]], dict[int, I64]]:
        """Let objects grow, judge and learn them: how they fared, and the points that each has.

        And the points of large objects that came out of hiding so changed that they are learnt
        anew.  What is small is judged while it is found out what hangs together with large objects.
        """
        tracks = self.tracks
        grown, taken = grow(tracks, findings)

        def given(track: Track) -> tuple[Registration | None, Claim | None, I64, TrackOptions]:
            n = track.label
            fit, claim = findings.fits.get(n), findings.claims.get(n)
            return fit, claim, grown.get(n, _EMPTY), self.asked

        alive = [track for track in sought if not track.lost]
        small = [track for track in alive if not track.large]
        meanwhile = small if any(tracks[label].large for label in findings.fits) else []
        wait = self.workers.begin(settle, meanwhile, given, changes=True)
        grown |= hang_together(tracks, findings, taken)
        emerged = bodies_left(loose, tracks, findings, grown)
        rest = [t for t in alive if not (t.label in emerged or t in meanwhile)]
        settled = wait()
        return settled | self.workers.each(settle, rest, given, changes=True), emerged

    def _conclude(
        self,
        view: View,
        rules: FrameRules,
        fixed: Mapping[int, I64],
        emerged: Mapping[int, I64],
        settled: Mapping[int, tuple[TrackState, I64]],
    ) -> dict[int, TrackState]:
        """Return how each object fared; its points go to ``view.labels``."""
        states: dict[int, TrackState] = {}
        for label, track in self.tracks.items():
            if label in fixed:
                states[label] = self._repainted(track, view, fixed[label])
                self.people.join(view, self.background, label)
            elif label in emerged:
                states[label] = self._emerge(track, view, emerged[label])
                view.labels[label] = emerged[label]
            elif label in settled:
                states[label], points = settled[label]
                points = together(points, rules.anchors(label))
                if len(points) and states[label].state != "lost":
                    view.labels[label] = points
                    states[label] = replace(states[label], points=len(points))
        return states

    def _repainted(self, track: Track, view: View, points: I64) -> TrackState:
        """Learn from a person's points: more of the same object, or all of it anew."""
        self.swaps.forget(track.label)
        pose = None if track.label in self.people else corrected(track, view, points)
        if pose is None:
            return self._begin_anew(track, view, points)
        world = transform(pose, track.model.xyz)
        set_other_movers_around(track, view, world)
        return _painted(len(points), pose)

    def _begin_anew(self, track: Track, view: View, points: I64) -> TrackState:
        noise = self.scene.noise(view, points)
        pose = begin_anew(self.tracks, view, track.label, points, noise)
        self.astray.pop(track.label, None)
        return _painted(len(points), pose)

    def _emerge(self, track: Track, view: View, points: I64) -> TrackState:
        """Learn a large object anew from what came out of hiding; the rest may follow."""
        options = self.options.track
        state = self._begin_anew(track, view, points)
        anew = self.tracks[track.label]
        anew.extent, anew.size, anew.confidence, anew.appearance = (
            track.span,
            track.size,
            options.emerged_confidence,
            track.appearance,
        )
        return replace(state, confidence=options.emerged_confidence, state="tracked")


def _meets(some: F64, fits: F64, margin: float) -> bool:
    """Return whether some of the points (N, 3) lie within ``margin`` metres of others."""
    lo, hi = fits.min(axis=0) - margin, fits.max(axis=0) + margin
    some = some[within(some, lo, hi)]
    if not len(some):
        return False
    away = ((some[:, None] - fits) ** 2).sum(axis=2)
    return bool(away.min() <= margin**2)


_EMPTY: I64 = np.empty(0, np.int64)


def _before(seeds: Sequence[Seed], known: FrameKnowledge | None) -> list[Seed]:
    """The seeds as they are in another frame, without points where nothing is known of it."""
    if known is None:
        return [Seed(seed.label, _EMPTY) for seed in seeds]
    label = np.where(known.deleted, 0, known.label)
    return [Seed(seed.label, np.flatnonzero(label == seed.label)) for seed in seeds]


def _painted(points: int, pose: F64) -> TrackState:
    return TrackState(pose, 0.0, 1.0, 1.0, points, "painted")
