"""Steps of compiling, each of which runs the loops of one feature on small generated recordings."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import ExampleFrame, describe, scale_of
from pointbrush.classify.forest import learn, probabilities
from pointbrush.classify.options import FeatureOptions, ForestOptions
from pointbrush.classify.smoothing import average_over_pieces, smoothed
from pointbrush.compiled import each_compiled, share_compiled
from pointbrush.frame import PointFrame
from pointbrush.samples import Recording, generate
from pointbrush.selection.objects import ObjectFrame, candidates
from pointbrush.selection.objects import prepare as prepare_objects
from pointbrush.sensor_kind import SensorKind
from pointbrush.sequences import kdtree
from pointbrush.sequences.columns import encode_frame
from pointbrush.sequences.octree.coordinates import Coordinates
from pointbrush.sequences.octree.grid import GridChooser
from pointbrush.sequences.octree.packed import PACKED
from pointbrush.sequences.octree.rows import Part
from pointbrush.sequences.octree.segment import encode_cube
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pointbrush.tracking.interface import ArrayFrame
from pointbrush.work.loops.compiling import Progress, Report, StepName

FRAMES = 5
"""Frames of a juggler with pins: a few seconds of work that runs nearly every loop."""
STEADY_SECONDS = 4.0
"""Weight of the expected pace in the estimate, seconds of work."""


def encode() -> None:
    """Encode a frame as in an import, also as a part of an octree, and build its tree."""
    made = generate("tabletop", 1, 1).frame(0)
    encode_frame(made, GridChooser()([made]))
    kdtree.build(made.xyz.astype(np.float32))
    _as_octree(replace(made, xyz=made.xyz.astype(np.float32)))
    _as_octree(replace(made, xyz=made.xyz.astype(np.float64)))


def _as_octree(made: PointFrame) -> None:
    """Encode a frame as a cube of an octree, and read a point of it."""
    part = Part(made, 0, 0, np.zeros(3))
    grid, scaling = GridChooser()([made]), np.ones((3, 3))
    segment = encode_cube(part.groups().rows, np.zeros(3), 1.0, 0, grid, scaling, hands_up=False)
    packed = segment.packed
    arrays: dict[str, NDArray[Any]] = {"block_first": np.append(segment.block_first, len(segment))}
    arrays |= zip(PACKED, (packed.words, packed.base, packed.bits), strict=True)
    meta = {"dtype": made.xyz.dtype.name, "scaling": scaling}
    Coordinates(arrays, meta, np.zeros(3))[:1]


def select_object() -> None:
    """Click on a frame, with and without a viewpoint, and correct the selection."""
    made = generate("tabletop", 1, 1).frame(0)
    views: tuple[tuple[SensorKind, NDArray[np.float64] | None], ...] = (
        ("lidar", made.viewpoint),
        ("room", None),
    )
    at = made.xyz[:2].astype(np.float64)
    for sensor, viewpoint in views:
        frame = ObjectFrame(made.xyz, made.rgb, viewpoint=viewpoint, sensor=sensor)
        state = prepare_objects(frame)
        taken = candidates(state, at[:1])[0].indices
        candidates(state, at[:1], at[1:], taken)


def label_by_example() -> None:
    """Compute features of a frame, train two classes, and predict."""
    made = generate("tabletop", 1, 1).frame(0)
    few = made.xyz[::8].astype(np.float32)
    options = FeatureOptions()
    seen = ExampleFrame(few, viewpoint=made.viewpoint, sensor="lidar")
    place = describe(seen, scale_of(few, options), options)
    chosen = np.arange(len(place.center), step=20)
    classes, spread = chosen % 2, np.ones(place.features.shape[1])
    trees = learn(place.features[chosen], classes, 2, spread, ForestOptions(trees=2))
    average_over_pieces(smoothed(probabilities(trees, place.features), place.near), place.piece)


def _aside(way: float) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[0, 3] = way
    return pose


def track(recording: Recording, method: str, moved: float = 0.0, leaves: int = 0) -> None:
    """Track all labels of the first frame of a recording to its end.

    ``moved``: motion of the sensor per frame, metres; the label ``leaves`` is visible only in the
    first frame.
    """
    frames = []
    for n, (made, truth) in enumerate(zip(recording.frames, recording.truth, strict=True)):
        seen = (truth == 0) | (truth != leaves) | (n == 0)
        xyz = made.xyz[seen].astype(np.float32)
        rgb = None if made.rgb is None else made.rgb[seen]
        frames.append(ArrayFrame(xyz, made.viewpoint, _aside(n * moved), rgb=rgb))
    first = recording.truth[0]
    seeds = [Seed(n, np.flatnonzero(first == n)) for n in np.unique(first).tolist() if n]
    run = METHODS[method]().track(
        frames.__getitem__, range(len(frames)), seeds, lambda _: None, TrackOptions()
    )
    for _ in run:
        pass


def track_things() -> None:
    """Track moving objects on a table."""
    track(generate("tabletop", 1, 3), "auto")


def track_people() -> None:
    """Track a juggler and pins, also with a moving sensor, and a person that leaves."""
    track(generate("juggling", 1, FRAMES, people=1, pins=3), "auto")
    track(generate("juggling", 1, 2, people=1, pins=3), "auto", moved=0.01)
    track(generate("walking", 1, 2), "auto", leaves=1)


def track_by_paper() -> None:
    """Track a step by the methods of the paper, which have few loops."""
    for method in METHODS.keys() - {"auto"}:
        track(generate("juggling", 1, 2, people=1, pins=3, label_people=False), method)


@dataclass(frozen=True)
class Step:
    """Work that compiles loops, including all loops of ``packages``.

    ``seconds``: processor time on a machine of 2020 after the earlier steps, the initial estimate.
    """

    run: Callable[[], None]
    packages: tuple[str, ...]
    seconds: float


RUNS: Mapping[StepName, Step] = {
    "objects": Step(select_object, ("pointbrush.selection.objects",), 17),
    "things": Step(track_things, ("pointbrush.tracking",), 36),
    "people": Step(track_people, ("pointbrush.tracking",), 9),
    "imports": Step(encode, ("pointbrush.sequences",), 14),
    "example": Step(label_by_example, ("pointbrush.classify",), 9),
    "paper": Step(track_by_paper, ("pointbrush.tracking",), 4),
}


def run_step(name: StepName, report: Report) -> None:
    """Compile the loops of a step; ``report`` receives its progress, and may raise to end it."""
    step, begun, share = RUNS[name], time.perf_counter(), 0.0

    def tell() -> None:
        nonlocal share  # late imports add loops to compile
        share = max(share, share_compiled(step.packages))
        report(estimate(share, time.perf_counter() - begun, step.seconds))

    tell()
    with each_compiled(tell):
        step.run()


def estimate(share: float, elapsed: float, expected: float) -> Progress:
    """Return the progress of a step after a ``share`` took ``elapsed`` of ``expected`` seconds."""
    pace = (elapsed + STEADY_SECONDS) / (share * expected + STEADY_SECONDS)
    return Progress(share, (1 - share) * expected * pace)
