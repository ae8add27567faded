"""Parts of a thing that were missed: taken back where they are nobody else's, hands never."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Bending, OtherMovers, Track, begin
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.depth import ImageBackground
from pointbrush.tracking.scene.images import DepthNoise
from pointbrush.tracking.sensors.camera import find_lens
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import cut_off
from pointbrush.tracking.steps.pieces import lost_pieces

OPTIONS = TrackerOptions()

BLUE, SKIN = (40, 90, 200), (210, 160, 130)


def shot(
    colour: tuple[int, int, int], reach: float, behind: float = 0.0
) -> tuple[View, ImageBackground]:
    """A blue box, label 1; beside it a block of ``colour``, label 2, that goes on for ``reach``.

    Or that comes out ``behind`` metres behind the box's face.
    """
    rng = np.random.default_rng(2)
    camera = scenes.Camera(scenes.Sensor(256, 212), scenes.room())
    empty = camera.shoot([], rng)
    lens = find_lens(empty, options=OPTIONS)
    first = View(0, empty, lens, options=OPTIONS)
    unknown = np.full_like(first.depth, np.nan)
    background = ImageBackground(
        OPTIONS, DepthNoise(0.004, 0.002), unknown, unknown.copy(), np.ones_like(unknown)
    )
    background.learn(first, first=True)
    box = scenes.Part(1, BLUE, np.array([0, 1.2, 1.6]), np.array([0.1, 0.12, 0.1]), rot=np.eye(3))
    block = scenes.Part(
        2,
        colour,
        np.array([0.1 + (reach if not behind else 0.0), 1.2, 1.6 + behind]),
        np.array([reach, 0.06, 0.1]),
        rot=np.eye(3),
    )
    return View(
        OPTIONS.pieces.slow_frames - 1, camera.shoot([box, block], rng), lens, options=OPTIONS
    ), background


def place_of(view: View, track: Track, core: np.ndarray) -> Registration:
    """Where a thing was found that shows its points ``core`` (M,)."""
    lo, hi = view.xyz[core].min(axis=0) - 0.25, view.xyz[core].max(axis=0) + 0.25
    box = (lo.astype(np.float64), hi.astype(np.float64))
    around = view.box(*box)
    return Registration(np.eye(4), track.model.xyz, box, around, around, around, 0.05)


@pytest.mark.parametrize(
    ("colour", "reach", "somebodys", "taken"),
    [
        (BLUE, 0.05, False, True),
        (SKIN, 0.05, False, False),  # other colours than were painted
        (BLUE, 0.6, False, False),  # goes on out of the box, as an arm does
        (BLUE, 0.1, False, False),  # ends within the box, but far beyond the thing's own size
        (BLUE, 0.05, True, False),  # somebody's
    ],
)
def test_a_piece_that_was_missed_is_taken_back(
    colour: tuple[int, int, int], reach: float, somebodys: bool, taken: bool
) -> None:
    view, background = shot(colour, reach)
    truth = view.frame.truth
    core, beside = np.flatnonzero(truth == 1), np.flatnonzero(truth == 2)
    none = OtherMovers.none()
    track = begin(view, 1, core, 0.004, none)
    track.size = 1.6 * len(core)  # it was larger before
    place = place_of(view, track, core)
    has = np.zeros(len(view.xyz), np.bool_)
    has[core] = True
    if somebodys:
        has[beside] = True
    found = lost_pieces(track, view, place, core, has, background)
    assert (len(np.intersect1d(found, beside)) > 0.8 * len(beside)) == taken
    assert len(np.setdiff1d(found, beside)) <= (0.1 * len(beside) if taken else 0)
    track.size = len(core)  # nothing of it is missing
    assert not len(lost_pieces(track, view, place, core, has, background))


def piece_found(view: View, background: ImageBackground, *, pliant: bool) -> np.ndarray:
    """What a colourless box takes back beside it."""
    core = np.flatnonzero(view.frame.truth == 1)
    track = begin(view, 1, core, 0.004, OtherMovers.none())
    track.weight, track.size = 0.0, 1.6 * len(core)
    if pliant:
        track.bending, track.size = (
            Bending(strain=2 * OPTIONS.track.soft_strain),
            2.0 * OPTIONS.track.dense_points,
        )
    place = place_of(view, track, core)
    has = np.zeros(len(view.xyz), np.bool_)
    has[core] = True
    return lost_pieces(track, view, place, core, has, background)


def test_a_piece_of_what_is_pliant_is_taken_back_without_colours() -> None:
    view, background = shot(BLUE, 0.05)
    beside = np.flatnonzero(view.frame.truth == 2)
    found = piece_found(view, background, pliant=True)
    assert len(np.intersect1d(found, beside)) > 0.8 * len(beside)
    assert not len(piece_found(view, background, pliant=False))


def test_an_arm_is_no_piece_of_what_is_pliant() -> None:
    assert not len(piece_found(*shot(BLUE, 0.6), pliant=True))


def beside_whole(
    view: View, background: ImageBackground, moves: float
) -> tuple[np.ndarray, np.ndarray]:
    """What is found beside a box of which nothing is known to be missing, and the block there.

    ``moves`` metres a frame.
    """
    core, beside = (np.flatnonzero(view.frame.truth == label) for label in (1, 2))
    track = begin(view, 1, core, 0.004, OtherMovers.none())
    for frame in range(OPTIONS.search.remembered_poses):
        pose = np.eye(4)
        pose[0, 3] = moves * frame
        track.motion = track.motion.add(pose)
    lo, hi = view.xyz[core].min(axis=0) - 0.25, view.xyz[core].max(axis=0) + 0.25
    box = (lo.astype(np.float64), hi.astype(np.float64))
    around = view.box(*box)
    place = Registration(pose, track.model.xyz + pose[:3, 3], box, around, around, around, 0.05)
    has = np.zeros(len(view.xyz), np.bool_)
    has[core] = True
    return lost_pieces(track, view, place, core, has, background), beside


def test_a_thing_on_the_move_has_sides_that_it_had_not_shown() -> None:
    found, beside = beside_whole(*shot(BLUE, 0.01), moves=0.05)
    assert len(np.intersect1d(found, beside)) > 0.8 * len(beside)


@pytest.mark.parametrize(
    ("reach", "frames", "moves", "taken"),
    [
        (0.01, OPTIONS.pieces.rested_frames + 1, 0.0, True),
        (0.01, 2, 0.0, False),  # a finger that has just come
        (
            0.01,
            OPTIONS.pieces.rested_frames + 1,
            0.05,
            False,
        ),  # a thing on the move, which a hand may hold
        (
            0.03,
            OPTIONS.pieces.rested_frames + 1,
            0.0,
            False,
        ),  # large: another thing may stand there
    ],
)
def test_what_has_come_to_rest_with_a_thing_is_its_whatever_its_colours(
    reach: float, frames: int, moves: float, taken: bool
) -> None:
    view, background = shot(SKIN, reach)
    view.labels = {1: np.flatnonzero(view.frame.truth == 1)}
    for _ in range(frames):
        background.learn(view)
    found, beside = beside_whole(view, background, moves)
    assert (len(np.intersect1d(found, beside)) > 0.8 * len(beside)) == taken
    assert len(np.setdiff1d(found, beside)) <= (0.1 * len(beside) if taken else 0)


def test_the_scene_that_a_thing_uncovers_is_no_lost_piece() -> None:
    view, background = shot(BLUE, 0.05)
    truth = view.frame.truth
    core, beside = np.flatnonzero(truth == 1), np.flatnonzero(truth == 2)
    none = OtherMovers.none()
    track = begin(view, 1, core, 0.004, none)
    track.size = 1.6 * len(core)
    box = (np.array([-0.4, 0.8, 1.2]), np.array([0.5, 1.6, 2.0]))
    around = view.box(*box)
    place = Registration(np.eye(4), track.model.xyz, box, around, around, around, 0.05)
    has = np.zeros(len(view.xyz), np.bool_)
    has[core] = True
    assert len(lost_pieces(track, view, place, core, has, background)) > 0.8 * len(beside)
    background.hidden = view.depth.copy()  # the scene, drawn on behind the first objects, is there
    assert not len(lost_pieces(track, view, place, core, has, background))


def test_what_comes_out_from_behind_the_thing_is_cut_off_by_it_alone() -> None:
    view, _ = shot(BLUE, 0.06, behind=0.13)
    core, beside = (np.flatnonzero(view.frame.truth == label) for label in (1, 2))
    assert cut_off(view, beside, 0.01, by=view.marked(core))
    assert not cut_off(view, beside, 0.01, by=view.marked(core[:0]))
    assert not cut_off(view, core, 0.01, by=view.marked(beside))
