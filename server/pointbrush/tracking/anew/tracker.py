"""`auto-next`: the loop of the steps for small objects before a depth camera."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace

import numpy as np

from pointbrush.tracking.anew.judge import judged
from pointbrush.tracking.anew.label import Labelling, label
from pointbrush.tracking.anew.priors import NextOptions
from pointbrush.tracking.anew.register import (
    Fits,
    is_doubtful,
    register,
    relocated,
    resolve,
)
from pointbrush.tracking.anew.smooth import Held, Smoother
from pointbrush.tracking.anew.track import Track, begin, in_its_place
from pointbrush.tracking.anew.update import unseen, updated
from pointbrush.tracking.compute.rigid import inverse, transform
from pointbrush.tracking.interface import (
    F32,
    F64,
    I64,
    FrameResult,
    Frames,
    Known,
    Mask,
    Seed,
    State,
    TrackOptions,
    TrackState,
)
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.permissions import FrameRules
from pointbrush.tracking.scene.scene import Scene
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.identity import Swaps

NO_POINTS: I64 = np.empty(0, np.int64)


@dataclass(frozen=True)
class NextTracker:
    """The method."""

    numbers: NextOptions = field(default_factory=NextOptions)
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
        run = Run(self, frames, list(order), sorted(seeds, key=lambda s: s.label), known, options)
        with closing(run.scene):
            first = run.start()
            back = {n: inverse(state.pose) for n, state in first.tracks.items()}
            yield run.scene.since(first, back, order[0])
            for result in run.through(order[1:]):
                yield run.scene.since(result, back, order[0])


class Run:
    """The state of one run: frozen tracks by label, and the scene."""

    def __init__(
        self,
        method: NextTracker,
        frames: Frames,
        order: list[int],
        seeds: list[Seed],
        known: Known,
        options: TrackOptions,
    ) -> None:
        self.options, self.numbers = method.options, method.numbers
        self.seeds, self.known, self.track_options = seeds, known, options
        self.tracks: dict[int, Track] = {}
        self.swaps = Swaps(self.options.identity)
        painted = np.concatenate([NO_POINTS, *(seed.indices for seed in seeds)])
        self.scene = Scene(
            frames, order, self._reach, painted, options=self.options,
            known=options.sensor, ahead=options.read_ahead,
        )  # fmt: skip
        self.smoother = Smoother(self.options.smoothing, self._back)

    def _reach(self, world: F32) -> F32:
        units = [t.unit for t in self.tracks.values()] or [self.options.track.default_unit_m]
        reach = self.options.track.static_units * float(np.median(units))
        return np.full(len(world), reach, np.float32)

    def start(self) -> FrameResult:
        """Begin the tracks from the painted points."""
        view = self.scene.first
        view.labels = {seed.label: np.sort(seed.indices) for seed in self.seeds}
        made = {
            n: begin(view, n, points, self.scene.noise(view, points))
            for n, points in view.labels.items()
        }
        self.tracks = {n: in_its_place(t, view, list(made.values())) for n, t in made.items()}
        self.scene.learn_first(survey=False)
        states = {
            n: TrackState(np.eye(4), 0.0, 1.0, 1.0, len(points), "painted")
            for n, points in view.labels.items()
        }
        return FrameResult(view.number, {}, states)

    def through(self, order: Sequence[int]) -> Iterator[FrameResult]:
        """Yield the smoothed results of the following frames."""
        for number in order:
            yield from self.smoother.take(self.step(number), self.tracks)
        yield from self.smoother.flush()

    def step(self, number: int) -> Held:
        """Track all labels into the next frame."""
        view, background = self.scene.view(number), self.scene.background
        rules = FrameRules(len(view.xyz), self.known(number), self.track_options)
        free = rules.free([seed.label for seed in self.seeds])
        fits, labels, moved = self._located(self.tracks, view, free)
        caps = self.swaps.meet({n: t.as_auto for n, t in self.tracks.items()}, fits)
        states: dict[int, TrackState] = {}
        view.labels = {}
        for n, track in self.tracks.items():
            self.tracks[n], states[n], points = self._settled(
                track, view, fits, labels, caps.get(n, 1.0), n in moved
            )
            if len(points):
                view.labels[n] = points
        keep = [_kept_place(self.tracks[n], view, fits) for n in self.tracks]
        background.learn(view, keep=np.concatenate([np.empty((0, 3)), *keep]))
        return Held(view, free, FrameResult(number, dict(view.labels), states), caps)

    def _located(
        self, tracks: Mapping[int, Track], view: View, free: Mask
    ) -> tuple[Fits, Labelling, set[int]]:
        """Register and label; tracks in doubt are looked for in the whole frame once."""
        background = self.scene.background
        there = {n: track for n, track in tracks.items() if not track.lost}
        fits = register(there, view, background, free)
        labels = label(tracks, fits, view, background, free, self.numbers)
        fits, labels = resolve(tracks, fits, labels, view, background, free, self.numbers)
        moved: set[int] = set()
        for n, track in there.items():
            if not is_doubtful(track, fits.get(n), labels, view):
                tracks[n] = replace(track, frames_astray=0)  # type: ignore[index]
                continue
            count = track.frames_astray + 1
            tracks[n] = replace(track, frames_astray=count)  # type: ignore[index]
            options = self.options.relocate
            if count > options.patient_frames and (view.number + n) % options.retry_frames:
                continue
            new = relocated(track, fits.get(n), labels, view, background, free)
            if new is not None:
                before = fits.get(n)
                if before is None or _apart(track, new.pose, before.pose) > track.model.radius:
                    moved.add(n)
                fits = fits | {n: new}
                labels = label(tracks, fits, view, background, free, self.numbers)
        return fits, labels, moved

    def _settled(
        self, track: Track, view: View, fits: Fits, labels: Labelling, cap: float, moved: bool
    ) -> tuple[Track, TrackState, I64]:
        """Judge and update a track; return its state and its sorted points."""
        fit, share = fits.get(track.label), labels.shares.get(track.label)
        verdict = judged(track, view, fit, share)
        if not verdict.seen or fit is None or share is None:
            after = unseen(track, self.track_options.continue_lost)
            lost = after.frames_unseen > self.options.update.lost_frames
            at = track.motion.poses[-1] if fit is None else fit.pose
            kind: State = "lost" if lost else "occluded"
            return after, TrackState(at, 0.0, 0.0, 0.0, 0, kind), NO_POINTS
        after = updated(track, view, fit, share, verdict, cap, moved, self.numbers)
        points = np.sort(share.claim.indices)
        rmse = float(np.sqrt(np.mean(share.claim.gap**2)))
        state = TrackState(
            fit.pose, rmse, verdict.verdict.inliers, after.confidence, len(points), "tracked"
        )
        return after, state, points

    def _back(self, track: Track, held: Held, free: Mask) -> tuple[Track, TrackState, I64]:
        tracks = {track.label: track}
        fits, labels, moved = self._located(tracks, held.view, free)
        cap = held.caps.get(track.label, 1.0)
        return self._settled(
            tracks[track.label], held.view, fits, labels, cap, track.label in moved
        )


def _apart(track: Track, one: F64, other: F64) -> float:
    centre = track.motion.centre[None]
    return float(np.linalg.norm(transform(one, centre) - transform(other, centre)))


def _kept_place(track: Track, view: View, fits: Fits) -> F64:
    """Return (M, 3) where a slow or resting track is, so that it is not learnt as background."""
    places = [np.empty((0, 3))]
    if track.slow and track.label in fits and track.label in view.labels:
        places.append(fits[track.label].world)
    if track.motion.rested is not None:
        world = transform(track.motion.rested, track.model.xyz)
        margin = -track.options.verdict.hidden_units * track.unit
        places.append(world[view.hides(world, margin)])
    return np.concatenate(places)
