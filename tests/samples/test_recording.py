"""A recording: the same for the same seed, in the Kinect's geometry, with a truth per point."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.samples import KINDS, Recording, generate
from pointbrush.samples.generating import small_camera


def small(kind: str, seed: int = 4) -> Recording:
    """Three frames by every third pixel, which take a tenth of the time."""
    made = generate(kind, seed=seed, frames=3)
    made.camera = small_camera(made.camera, 3)
    return made


@pytest.fixture(scope="module", params=sorted(KINDS))
def recording(request: pytest.FixtureRequest) -> Recording:
    return small(request.param)


def test_the_same_seed_gives_the_same_frames_in_any_order(recording: Recording) -> None:
    again = small(recording.name.split()[0].lower())
    for i in (2, 0):
        np.testing.assert_array_equal(again.frame(i).xyz, recording.frame(i).xyz)
        np.testing.assert_array_equal(again.frame(i).rgb, recording.frame(i).rgb)
        np.testing.assert_array_equal(again.truth[i], recording.truth[i])


def test_another_seed_gives_another_recording(recording: Recording) -> None:
    other = small(recording.name.split()[0].lower(), seed=5)
    assert not np.array_equal(other.frame(0).pixel, recording.frame(0).pixel)


def test_points_are_the_valid_pixels_of_the_depth_camera() -> None:
    frame = generate("tabletop", seed=4, frames=2).frame(1)
    camera, pixel = frame.camera, frame.pixel
    assert camera is not None
    assert pixel is not None
    assert (camera.width, camera.height) == (512, 424)
    assert 150_000 < len(frame) < 512 * 424
    assert len(frame) + frame.dropped == 512 * 424
    assert (np.diff(pixel.astype(np.int64)) > 0).all()
    x, y, z = frame.xyz.T.astype(np.float64)
    np.testing.assert_allclose(x / z * camera.fx + camera.cx, pixel % 512, atol=1e-3)
    np.testing.assert_allclose(y / z * camera.fy + camera.cy, pixel // 512, atol=1e-3)
    assert z.min() >= 0.5
    assert z.max() <= 6.0
    np.testing.assert_allclose(z * 1000, np.round(z * 1000), atol=1e-3)
    assert frame.viewpoint is not None
    np.testing.assert_array_equal(frame.viewpoint, 0)


def test_every_point_has_a_truth_and_every_label_of_it_is_in_the_palette(
    recording: Recording,
) -> None:
    ids = {label.id for label in recording.labels}
    for frame, truth in zip(recording.frames, recording.truth, strict=True):
        assert truth.shape == (len(frame),)
        assert truth.dtype == np.uint16
        assert set(np.unique(truth).tolist()) <= ids | {0}
    assert all((recording.truth[0] == label).sum() > 10 for label in ids)


def test_a_crowd_has_somebody_at_the_edge_of_the_picture_and_some_leave_it() -> None:
    recording = generate("crowd", seed=3, frames=30, rate=5.0, people=3)
    recording.camera = small_camera(recording.camera, 4)
    assert {1, 2, 3} - set(recording.truth[24].tolist())
    pixel, width = recording.frame(0).pixel, recording.camera.width
    edge = (pixel % width < 2) | (pixel % width >= width - 2)
    edge |= pixel // width >= recording.camera.height - 2
    assert np.isin(recording.truth[0][edge], (1, 2, 3)).any()


def test_labels_have_names_categories_and_colours(recording: Recording) -> None:
    names = [label.name for label in recording.labels]
    assert len(set(names)) == len(names)
    assert [label.id for label in recording.labels] == list(range(1, len(names) + 1))
    assert all(len(label.color) == 7 and label.color[0] == "#" for label in recording.labels)


def test_poses_stay_with_their_points(recording: Recording) -> None:
    """The truth of a rigid thing lies within its size of its true pose."""
    for label, poses in recording.poses.items():
        assert len(poses) == len(recording)
        for i, T_world_object in enumerate(poses):
            R = T_world_object[:3, :3]
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
            points = recording.frame(i).xyz[recording.truth[i] == label]
            if len(points) > 40:
                far = np.linalg.norm(points - T_world_object[:3, 3], axis=1)
                assert np.quantile(far, 0.98) < 0.4


def test_a_frame_out_of_range_is_not_there(recording: Recording) -> None:
    with pytest.raises(NotFoundError, match=r"expected a frame 0\.\.2, got 3"):
        recording.frame(3)
    with pytest.raises(IndexError):
        recording.truth[-1]
    assert len(recording.frames[1:]) == 2


def test_a_recording_can_be_handed_to_another_process(recording: Recording) -> None:
    copy = pickle.loads(pickle.dumps(recording))
    np.testing.assert_array_equal(copy.frame(1).xyz, recording.frame(1).xyz)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "circus"}, "expected one of crowd, juggling, tabletop, walking, got 'circus'"),
        ({"frames": 0}, "expected 1 or more, got 0"),
        ({"seed": -1}, "seed: expected 0 or more"),
        ({"noise": -1.0}, "noise: expected 0 to 10"),
        ({"clubs": 3}, "clubs"),
        ({"pins": 40}, "pins: expected one of"),
        ({"people": 3}, "people: expected 1 or 2, got 3"),
        ({"pattern": "54"}, "expected a valid siteswap"),
        ({"pattern": "7"}, "expected a siteswap of 6 pins, got 7"),
        ({"held": 9}, "held: expected 0 to 2"),
        ({"kind": "tabletop", "things": 0}, "things: expected 1 to 8"),
        ({"kind": "crowd", "people": 2}, "people: expected 3 to 5"),
        ({"rate": 60}, "rate: expected 1 to 30"),
        ({"kind": "walking", "people": 9}, "people: expected 1 to 4"),
        ({"kind": "walking", "pace": 9}, "pace: expected 0.3 to 2"),
        ({"kind": "walking", "boxes": 3}, "boxes: expected 0 to 2"),
    ],
)
def test_bad_options_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(BadInputError, match=message):
        generate(**arguments)  # type: ignore[arg-type]
