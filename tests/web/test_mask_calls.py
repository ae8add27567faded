"""Masks of pictures and depth images become labels of points, and labels become masks."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image

from pointbrush.client import Client
from pointbrush.client.recording import Recording
from pointbrush.errors import BadInputError, LockedLabelError, NotFoundError
from pointbrush.frame import DepthCamera
from pointbrush.sequences import RecordingInfo, import_frames
from tests.depth_camera import FOCAL, HEIGHT, WIDTH, depth_camera, grey_pictures
from tests.services import example_service
from tests.serving import TOKEN, Served, serving, settings_in
from tests.web.calls import npy

K = np.array([[FOCAL, 0, 64], [0, FOCAL, 53], [0, 0, 1.0]])
PART = (slice(20, 50), slice(30, 90))
"""Rows and columns of the pixels of the tests' masks."""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Where the documented example of a model listens."""
    with example_service("mask_server.py") as url:
        yield url


@pytest.fixture
def served(tmp_path: Path, address: str) -> Iterator[Served]:
    """Recordings of one frame: ``kinect`` with a depth image, a camera at its place and one without
    calibration; ``cloud`` of the same points alone.
    """
    settings = settings_in(tmp_path, mask_models=f"toy={address}")
    camera = DepthCamera(WIDTH, HEIGHT, FOCAL, FOCAL, 64, 53)
    pixel = np.arange(WIDTH * HEIGHT, dtype=np.uint32)
    source = grey_pictures(1, (WIDTH, HEIGHT), {"colour": K, "unknown": None})
    found = depth_camera(0)
    assert found.rgb is not None
    found.rgb.reshape(HEIGHT, WIDTH, 3)[PART] = (250, 0, 0)
    frames = {"kinect": replace(found, camera=camera, pixel=pixel), "cloud": depth_camera(0)}
    for name, frame in frames.items():
        target = settings.workspace / "sequences" / name
        shown = source if name == "kinect" else None
        import_frames([frame], target, RecordingInfo(name, name, 30.0), pictures=shown)
    with serving(settings) as running:
        yield running


@pytest.fixture
def kinect(served: Served) -> Iterator[Recording]:
    with Client(served.url, TOKEN) as client:
        yield client["kinect"]


def test_mask_of_depth_image_labels_exactly_its_points(kinect: Recording) -> None:
    frame = kinect.frames[0]
    row, column = frame.points()["pixel"].T
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[PART] = 3
    inside = mask[row, column] == 3
    pin = kinect.create_label("pin")
    done = frame.set_mask("depth", mask, {3: "pin"})
    assert (done.changed, done.seen, done.doubt) == (1800, 1800, 0)
    assert ((frame.annotation() == pin.id) == inside).all()
    assert (frame.annotation("provenance")[inside] == 3).all()
    assert np.array_equal(frame.mask("depth") == pin.id, mask == 3)
    kinect.undo()
    assert not frame.annotation().any()


def test_found_lattice_has_the_orientation_of_the_camera(served: Served) -> None:
    with Client(served.url, TOKEN) as client:
        points = client["cloud"].frames[0].points()
    row, column = points["pixel"].T.astype(int)
    x, y, z = points["xyz"].T
    assert np.corrcoef(row, y / z)[0, 1] > 0.999
    assert np.corrcoef(column, x / z)[0, 1] > 0.999


def test_painted_and_locked_points_keep_their_labels(kinect: Recording) -> None:
    frame = kinect.frames[0]
    painted, locked, new = (kinect.create_label(name) for name in ("p", "l", "n"))
    xyz = frame.points()["xyz"]
    frame.stroke(label=painted.id, radius=0.2, samples=xyz[:1])
    frame.set_mask("depth", np.eye(HEIGHT, WIDTH), {1: locked.id})
    kinect.update_label(locked.id, locked=True)
    before = frame.annotation()
    frame.set_mask("depth", np.ones((HEIGHT, WIDTH)), {1: new.id})
    assert np.array_equal(frame.annotation(), np.where(before > 0, before, new.id))
    with pytest.raises(LockedLabelError):
        frame.set_mask("depth", np.ones((HEIGHT, WIDTH)), {1: locked.id})
    done = frame.set_mask("depth", np.ones((HEIGHT, WIDTH)), {1: 0}, source="painted")
    assert done.changed > 0
    assert set(frame.annotation()) == {0, locked.id}


def test_png_of_labels_comes_back_as_the_same_labels(served: Served, kinect: Recording) -> None:
    frame, label = kinect.frames[0], kinect.create_label("brick", color="#102030")
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[PART] = 1
    url = f"{served.url}/api/v1/sequences/kinect/frames/0/masks/"
    whole = served.headers | {"Content-Type": "application/x-npy"}
    big_endian = npy(mask.astype(">u2") * label.id)
    assert httpx.put(url + "depth", content=big_endian, headers=whole).is_success
    given = frame.annotation()
    for camera, unlabelled in (("depth", 0.0), ("colour", 0.1)):
        answer = httpx.get(url + camera, headers=served.headers)
        image = Image.open(io.BytesIO(answer.content))
        assert (image.mode, image.size) == ("P", (WIDTH, HEIGHT))
        assert image.getpalette()[3 * label.id :][:3] == [16, 32, 48]
        known = served.headers | {"If-None-Match": answer.headers["etag"]}
        assert httpx.get(url + camera, headers=known).status_code == 304
        frame.clear([label.id])
        headers = served.headers | {"Content-Type": "image/png"}
        assert httpx.put(url + camera, content=answer.content, headers=headers).is_success
        back = frame.annotation()
        assert (back[back > 0] == given[back > 0]).all()
        assert ((given > 0) & (back == 0)).sum() <= unlabelled * (given > 0).sum()
        kinect.undo()
        kinect.undo()


def test_label_id_over_254_makes_mask_16_bit(served: Served, kinect: Recording) -> None:
    frame = kinect.frames[0]
    kinect.create_label("far", id=300)
    mask = np.zeros((HEIGHT, WIDTH), np.uint16)
    mask[PART] = 300
    frame.set_mask("depth", mask)
    url = f"{served.url}/api/v1/sequences/kinect/frames/0/masks/depth"
    answer = httpx.get(url, headers=served.headers)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(answer.content))), mask)
    kinect.update_label(300, color="#102030")
    answer = httpx.get(url, params={"format": "picture"}, headers=served.headers)
    shown = np.asarray(Image.open(io.BytesIO(answer.content)))
    assert (shown[mask == 300] == [16, 32, 48, 255]).all()
    assert not shown[mask == 0, 3].any()


def test_wrong_masks_are_refused_in_words(kinect: Recording) -> None:
    frame = kinect.frames[0]
    kinect.create_label("wall")
    mask = np.ones((HEIGHT, WIDTH), np.uint8)
    for camera, array, classes, error, words in (
        ("depth", mask[1:], {1: "wall"}, BadInputError, r"\(106, 128\).* got \(105, 128\)"),
        ("left", mask, {1: "wall"}, NotFoundError, "depth, colour, unknown.* got 'left'"),
        ("unknown", mask, {1: "wall"}, BadInputError, "calibration, its K is not known"),
        ("depth", mask, {1: "dog"}, BadInputError, "'wall'.* got 'dog' for value 1"),
        ("depth", mask, {1: 77}, BadInputError, "got 77 for value 1"),
        ("depth", mask, {2: "wall"}, BadInputError, "of values 2, got 1"),
        ("depth", mask * 255, None, BadInputError, "label ids, got only 0"),
        ("depth", mask.astype(float) / 2, None, BadInputError, "whole numbers .* got 0.5"),
    ):
        with pytest.raises(error, match=words):
            frame.set_mask(camera, array, classes)


def test_predicted_mask_adds_its_classes(kinect: Recording) -> None:
    frame = kinect.frames[0]
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    mask[PART] = 255
    frame.set_mask("colour", mask, {255: "person"}, source="predicted")
    (label,) = kinect.labels()
    assert (label.name, label.category) == ("person", "person")
    labelled = frame.annotation() == label.id
    assert labelled.sum() > 1500
    assert (frame.annotation("provenance")[labelled] == 4).all()
    assert frame.annotation("confidence")[labelled].min() > 240


def test_masks_of_a_model_become_predicted_labels(kinect: Recording) -> None:
    frame, mine = kinect.frames[0], kinect.create_label("mine")
    row, column = frame.points()["pixel"].T.astype(int)
    inside = np.zeros((HEIGHT, WIDTH), np.bool_)
    inside[PART] = True
    on = [[PART[1].start + 2, PART[0].start + 2]]
    done = frame.predict_mask("depth", "toy", positives=on, label=mine.id)
    assert done.changed == inside.sum()
    assert ((frame.annotation() == mine.id) == inside[row, column]).all()
    assert set(frame.annotation("provenance")) == {0, 4}
    kinect.undo()
    frame.predict_mask("depth", "toy", text="the red board")
    (red,) = (each for each in kinect.labels() if each.id != mine.id)
    assert red.name == "red"
    assert ((frame.annotation() == red.id) == inside[row, column]).all()
    for camera, model, error, words in (
        ("depth", "sam", BadInputError, "expected one of toy; got 'sam'"),
        ("unknown", "toy", BadInputError, "its K is not known"),
        ("colour", "toy", NotFoundError, "an object in the picture of 'colour', found none"),
    ):
        with pytest.raises(error, match=words):
            frame.predict_mask(camera, model, text="red")
