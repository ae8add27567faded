"""Agreement of two annotators: per label by name, per frame, as a picture."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.work.reviewing.comparing import COLORS, Difference, agreement, draw, pairs
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in


def test_iou_of_labels_that_have_other_numbers() -> None:
    mine = np.array([1, 1, 1, 1, 0, 0, 2, 2], np.uint16)
    theirs = np.array([7, 7, 7, 0, 7, 0, 9, 9], np.uint16)
    found = agreement({0: pairs(mine, theirs)}, {1: "pin", 2: "ball"}, {7: "pin", 9: "club"})
    told = {each.name: (each.first, each.second, each.both, each.iou) for each in found.labels}
    assert told == {
        "pin": (4, 4, 3, pytest.approx(3 / 5)),
        "ball": (2, 0, 0, 0.0),
        "club": (0, 2, 0, 0.0),
    }
    (frame,) = found.frames
    assert (frame.labelled, frame.differ) == (7, 4)
    assert found.same == pytest.approx(3 / 7)
    assert found.miou == pytest.approx(0.2)


def test_nothing_labelled_is_no_agreement() -> None:
    empty = np.zeros(5, np.uint16)
    found = agreement({0: pairs(empty, empty)}, {}, {})
    assert (found.miou, found.same) == (None, None)


def colors_of(png: bytes) -> set[tuple[int, ...]]:
    image = np.asarray(Image.open(io.BytesIO(png)))
    return set(map(tuple, image.reshape(-1, 3).tolist()))


def test_the_picture_shows_each_kind_of_difference() -> None:
    random = np.random.default_rng(0)
    kinds = np.repeat(np.array(list(Difference), np.uint8), 50)
    shown = colors_of(draw(random.uniform(0, 9, (len(kinds), 2)), kinds))
    assert set(COLORS.values()) <= shown
    assert len(colors_of(draw(np.empty((0, 2)), np.empty(0, np.uint8)))) == 1


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    for name in ("ada", "grace"):
        add_sequence(settings, name, frames=3, points=2000)
    add_sequence(settings, "other", frames=3, points=1000)
    opened = Workspace(settings)
    for name in ("ada", "grace"):
        opened.labels.create_label(name, name, name="pin")
    yield opened
    opened.close()


def test_two_people_label_a_recording_each(workspace: Workspace) -> None:
    for name, stop in (("ada", 300), ("grace", 200)):
        annotation = np.zeros(workspace.recording(name)[1].count, np.uint16)
        annotation[:stop] = 1
        workspace.annotations.put(name, 1, annotation, author=name)
    found = workspace.reviewing.agreement("ada", "grace")
    assert [(each.name, each.iou) for each in found.labels] == [("pin", pytest.approx(2 / 3))]
    assert [each.differ for each in found.frames] == [0, 100, 0]
    noise = np.zeros(workspace.recording("ada")[1].count, bool)
    noise[250:] = True
    workspace.annotations.put("ada", 1, noise, author="ada", layer="deleted")
    (label,) = workspace.reviewing.agreement("ada", "grace", frames="1").labels
    assert label.iou == pytest.approx(200 / 250)
    shown = colors_of(workspace.reviewing.difference("ada", "grace", 1))
    assert COLORS[Difference.FIRST] in shown
    assert COLORS[Difference.SECOND] not in shown
    assert COLORS[Difference.SECOND] in colors_of(workspace.reviewing.difference("grace", "ada", 1))


def test_labels_of_one_category_are_compared_by_it(workspace: Workspace) -> None:
    for name, called in (("ada", "1"), ("grace", "car one")):
        label = workspace.labels.create_label(name, name, name=called, category="car").id
        annotation = np.full(workspace.recording(name)[0].count, label, np.uint16)
        workspace.annotations.put(name, 0, annotation, author=name)
    assert workspace.reviewing.agreement("ada", "grace").miou == 0
    assert workspace.reviewing.agreement("ada", "grace", "category").miou == 1


def test_recordings_of_other_points_are_refused(workspace: Workspace) -> None:
    with pytest.raises(BadInputError, match="same points"):
        workspace.reviewing.agreement("ada", "other")
    with pytest.raises(BadInputError, match="same points"):
        workspace.reviewing.difference("ada", "other", 0)
