"""Sensor of a run, and the static scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pointbrush.tracking.interface import (
    F32,
    F64,
    I64,
    FrameResult,
    Frames,
    KnownSensor,
    TrackFrame,
)
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import Background, ImageBackground
from pointbrush.tracking.scene.images import default_noise, measure_noise
from pointbrush.tracking.scene.mapped import MapBackground, SurfaceMap, chart_of
from pointbrush.tracking.scene.scans import PointBackground
from pointbrush.tracking.sensors.camera import Lens, find_lens, steadied
from pointbrush.tracking.sensors.examination import lens_at_rest
from pointbrush.tracking.sensors.scan_odometry import find_trajectory
from pointbrush.tracking.sensors.scanner import find_eye, range_image_of
from pointbrush.tracking.sensors.sights import Lenses, find_lenses, mounted_alike
from pointbrush.tracking.sensors.trajectory import Trajectory
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.sensors.visual_odometry import framed


class Scene:
    """The frames ``order`` of a recording, seen by one sensor.

    ``first``: first frame; ``lens``: pixel grid of the sensor or None; ``background``: learnt
    background model.
    """

    def __init__(
        self,
        frames: Frames,
        order: list[int],
        reach: Callable[[F32], F32],
        painted: I64 | None = None,
        *,
        options: TrackerOptions,
        known: KnownSensor,
        ahead: bool,
    ) -> None:
        """``reach``: see ``PointBackground``; ``ahead``: a thread may prepare the next frame.

        Properties of the sensor in ``known`` are not estimated.  The ``painted`` points (M,) of the
        first frame may move, and are excluded from estimates of the sensor.
        """
        self._frames, self._order, self.options = frames, order, options
        # The work is mostly array operations, which release the interpreter lock.
        self._ahead = ThreadPoolExecutor(1) if ahead else None
        self._following = dict(pairwise(order))
        self._ready: tuple[int, Future[View]] | None = None
        first, *others = (frames(order[at]) for at in (0, len(order) // 2, -1))
        self.lens: Lens | Lenses | None = lens_at_rest(first, others, known, options=options)
        self._way: Trajectory | None = None
        self._about: F64 | None = None
        self._mounts_move = False
        if first.sensor is not None:
            least = options.scan_odometry.rest_pose
            self._mounts_move = not mounted_alike(first, others, least)
            self._way = find_trajectory(frames, order, at_rest=known.at_rest, options=options)
            self.lens = find_lenses([first, *others], options=options)
        elif self.lens is None:
            self._way = find_trajectory(
                frames, order, painted, at_rest=known.at_rest, options=options
            )
            self.lens, self._about = _sensor(
                first, others, moves=self._way is not None, options=options
            )
        self._steady = False
        self.first = self._look(order[0])
        self._steady_it()
        self._noise = default_noise(options.noise)
        self.background: Background = PointBackground(options, reach)
        if self.lens is not None and not self._moves:
            self.background = self._picture_background(self.lens, painted)
        self._reach = reach

    def _picture_background(self, lens: Lens | Lenses, painted: I64 | None) -> ImageBackground:
        """Return the background of depth cameras at rest, with noise measured on two frames."""
        depth, options = self._beside(painted), self.options
        if len(self._order) > 1:
            noise = measure_noise(depth, self._look(self._order[1]).depth, options=options.noise)
            # A figure cut out of its room may have no static point.
            far = np.nanmedian(depth, keepdims=True)
            calm = noise(far) < default_noise(options.noise)(far)
            if calm or (isinstance(lens, Lens) and framed(self.first.frame, lens, options=options)):
                self._noise = noise
        unknown = np.full_like(depth, np.nan)
        return ImageBackground(options, self._noise, unknown, unknown)

    def _steady_it(self) -> None:
        """Treat a swaying depth camera as a camera at rest."""
        if not isinstance(self.lens, Lens) or self._way is None:
            return
        some = [self._order[0], *self._apart()]
        way = self._way.over(some)
        poses = [way.pose(number) for number in some]  # a lost pose is the last one found
        seen = len(way.lost) <= self.options.background.covered_share * len(some)
        still = (
            steadied(self.lens, self.first.cells.depth, poses, options=self.options)
            if seen
            else None
        )
        if still is not None:
            self.lens, self._steady = still, True
            self.first = self._look(self._order[0])

    def _beside(self, painted: I64 | None) -> F32:
        """Return the first depth image without ``painted`` points (M,), unless too few remain."""
        depth = self.first.depth.copy()
        if painted is not None:
            depth[self.first.cells.cell[painted]] = np.nan
        enough = (
            np.isfinite(depth).sum()
            > self.options.background.min_picture_share * np.isfinite(self.first.depth).sum()
        )
        return depth if enough else self.first.depth

    def view(self, number: int) -> View:
        """Return frame ``number`` with the sensor's properties."""
        ready, self._ready = self._ready, None
        view = ready[1].result() if ready and ready[0] == number else self._look(number)
        if self._ahead is not None and number in self._following:
            following = self._following[number]
            self._ready = following, self._ahead.submit(self._prepared, following)
        return view

    def close(self) -> None:
        """Stop preparing frames."""
        if self._ahead is not None:
            self._ahead.shutdown(cancel_futures=True)

    def _prepared(self, number: int) -> View:
        view = self._look(number)
        view.prepare()
        return view

    def _look(self, number: int) -> View:
        frame, lens = self._frames(number), self.lens
        if self._mounts_move and lens is not None:
            lens = find_lenses([frame], options=self.options)
        return View(
            number,
            frame,
            lens,
            self.options,
            self._pose(number),
            self._about,
            self._steady,
        )

    def since(self, found: FrameResult, back: Mapping[int, F64], start: int) -> FrameResult:
        """Return a result with poses relative to frame ``start``, in the frames' coordinates.

        ``back``: inverse pose in that frame, in the world, by label.
        """
        T_world_frame, T_world_start = self._pose(found.frame), self._pose(start)
        tracks = {}
        for label, track in found.tracks.items():
            pose = track.pose @ back[label]
            if T_world_frame is not None and T_world_start is not None:
                pose = np.linalg.inv(T_world_frame) @ pose @ T_world_start
            tracks[label] = replace(track, pose=pose)
        return replace(found, tracks=tracks)

    @property
    def _moves(self) -> bool:
        return self._mounts_move or (self._way is not None and not self._steady)

    def _pose(self, number: int) -> F64 | None:
        return None if self._way is None else self._way.pose(number)

    def noise(self, view: View, indices: I64) -> float:
        """Return the median depth noise (m) at some points."""
        if self.lens is None or not len(indices):
            return 0.0
        return float(np.median(self._noise(view.cells.depth[indices])))

    def learn_first(self, *, survey: bool) -> None:
        """Learn the background of the first frame, which a person labelled.

        ``survey``: learn the scene behind large objects from the whole recording.
        """
        if survey and isinstance(self.lens, Lens) and self._moves:
            self.background = self._charted()
        if not isinstance(self.background, ImageBackground):
            self.background.learn(self.first, first=True)
            return
        self.background.learn(self.first, first=True)
        if survey:
            self.background.survey(self.first, self._survey())

    def _apart(self) -> list[int]:
        """Return spaced frames of the whole run."""
        last = len(self._order) - 1
        return [
            self._order[i]
            for i in np.linspace(1, last, min(self.options.background.survey_frames, last)).astype(
                int
            )
        ]

    def _survey(self) -> list[View]:
        return self._views(self._apart())

    def _charted(self) -> MapBackground:
        views = [self.first, *self._survey()]
        if len(views) > 1:
            before = SurfaceMap.of(self.first, self.first.depth).drawn(views[1])
            self._noise = measure_noise(before, views[1].depth, options=self.options.noise)
        return MapBackground(
            self.options,
            self._reach,
            self._noise,
            chart_of(views, self._noise, options=self.options),
        )

    def _views(self, numbers: Sequence[int]) -> list[View]:
        return [self._look(number) for number in numbers]


def _sensor(
    first: TrackFrame, others: Sequence[TrackFrame], *, moves: bool, options: TrackerOptions
) -> tuple[Lens | None, F64 | None]:
    """Return the sensor's pixel grid, or its position (3,) if neither grid nor frame has it.

    The position must be valid in the ``others`` as well: a moving sensor has no fixed position.
    """
    lens = find_lens(first, moves=moves, options=options)
    if lens is not None or first.viewpoint is not None:
        return lens, None
    xyz = np.asarray(first.xyz)
    about = find_eye(xyz, options=options)
    later = [np.asarray(frame.xyz) for frame in others]
    full = [p for p in later if len(p) >= options.range_image.min_points]
    if about is not None and any(range_image_of(p, about, options=options) is None for p in full):
        about = None
    return None, about
