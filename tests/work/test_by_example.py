"""A classifier taught by what is painted labels the rest, and nothing that somebody labelled."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.classify.classifier import Classifier
from pointbrush.classify.features import Described
from pointbrush.classify.models import Question
from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.exchange import model_names
from pointbrush.frame import PointFrame
from pointbrush.labels import Category, Write
from pointbrush.labels.types import IMPORTED, PAINTED, PREDICTED, TRACKED
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.values.classifiers import Application
from pointbrush.work.classifiers.agreeing import average_chances, voter_of
from pointbrush.work.classifiers.applying import predict_frame
from pointbrush.work.classifiers.options import ClassifierOptions
from pointbrush.work.classifiers.service import Classifiers
from pointbrush.workspace import Workspace
from tests.serving import settings_in

FLAT, TALL = 3000, 1500


def scene(seed: int) -> PointFrame:
    """A floor and a wall on it, z up, metres."""
    rng = np.random.default_rng(seed)
    floor = np.column_stack([rng.uniform(0, 3, (FLAT, 2)), rng.normal(0, 0.005, FLAT)])
    wall = np.column_stack([rng.uniform(0, 3, TALL), np.full(TALL, 3.0), rng.uniform(0, 2, TALL)])
    return PointFrame(np.concatenate([floor, wall]).astype(np.float32))


IS_WALL = np.arange(FLAT + TALL) >= FLAT
FLOOR, WALL = 1, 2


@pytest.fixture
def workspace(tmp_path: Path) -> Iterator[Workspace]:
    """Two frames of a floor and a wall, of which a little is painted in the first."""
    options = settings_in(tmp_path)
    for name in ("room", "other"):
        folder = Path(options.workspace) / "sequences" / name
        folder.parent.mkdir(parents=True, exist_ok=True)
        frames = (scene(i) for i in range(2))
        import_frames(frames, folder, RecordingInfo(name, name, 1.0))
    with closing(Workspace(options)) as opened:
        for name in ("floor", "wall"):
            opened.labels.create_label("room", "me", name=name)
        paint(opened, 0, np.r_[0:200], FLOOR)
        paint(opened, 0, np.r_[FLAT : FLAT + 200], WALL)
        yield opened


def paint(
    workspace: Workspace, frame: int, source: NDArray[np.int64], label: int, came: int = PAINTED
) -> None:
    """Give points, by their numbers in the source, a label."""
    numbers = np.flatnonzero(np.isin(workspace.recording("room")[frame].source_index, source))
    write = Write(numbers, label=label, provenance=came)
    workspace.labels.apply(
        "room", edit_id=None, author="me", kind="stroke", writes={frame: write}, summary="painted"
    )


def layer(workspace: Workspace, frame: int, name: str = "label") -> NDArray[np.generic]:
    return workspace.annotations.read("room", frame, name)[0]


def apply(workspace: Workspace, **chosen: object) -> dict[str, object]:
    job = workspace.predictions.start("room", Application(**{"above": 0.0} | chosen), "me")  # type: ignore[arg-type]
    ended = workspace.runner.wait(job.id, 60)
    assert ended.state == "done", ended.error
    assert ended.result is not None
    return ended.result


def test_the_rest_follows_what_is_painted(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    assert made.classes == ("floor", "wall")
    assert made.taught_by.keys() == {"room"}
    for frame in (0, 1):
        found = workspace.classifiers.predict(made.id, "room", frame)
        stored = workspace.recording("room")[frame]
        right = (stored.to_source(found.label) == WALL) == IS_WALL
        assert right.mean() > 0.97
    assert not layer(workspace, 1).any()
    assert workspace.classifiers.predict(made.id, "room", 1, labels=[WALL]).label.min() == WALL


def test_applying_is_one_edit_that_spares_what_people_did(workspace: Workspace) -> None:
    workspace.labels.create_label("room", "me", name="mine")
    workspace.labels.create_label("room", "me", name="kept", locked=True)
    spared = {
        PAINTED: np.r_[300:320], TRACKED: np.r_[400:420], IMPORTED: np.r_[500:520],
    }  # fmt: skip
    for came, points in spared.items():
        paint(workspace, 1, points, 3, came)
    paint(workspace, 1, np.r_[600:620], 0)  # erased
    gone = np.zeros(FLAT + TALL, np.bool_)
    gone[700:720] = True
    workspace.annotations.put("room", 1, gone, author="me", layer="deleted")
    before = layer(workspace, 1).copy()
    made = workspace.classifiers.create("rooms", ["room"], ["floor", "wall"])
    result = apply(workspace, classifier=made.id, frames="1")
    after, came = layer(workspace, 1), layer(workspace, 1, "provenance")
    held = np.concatenate([*spared.values(), np.r_[600:620], np.r_[700:720]])
    assert np.array_equal(after[held], before[held])
    free = np.setdiff1d(np.arange(len(after)), held)
    assert ((after[free] == WALL) == IS_WALL[free]).mean() > 0.97
    assert (came[free] == PREDICTED).all()
    assert layer(workspace, 1, "confidence")[free].mean() > 128
    assert result["changed"] == len(free)
    assert (layer(workspace, 0, "provenance") != PREDICTED).all()
    workspace.labels.undo("room", "me")
    assert np.array_equal(layer(workspace, 1), before)
    assert not layer(workspace, 1, "confidence").any()


def test_strokes_win_over_predictions_and_may_be_applied_again(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    apply(workspace, classifier=made.id, frames="1")
    paint(workspace, 1, np.r_[0:50], WALL)
    apply(workspace, classifier=made.id, frames="1")
    assert (layer(workspace, 1)[:50] == WALL).all()
    assert (layer(workspace, 1, "provenance")[:50] == PAINTED).all()
    assert not layer(workspace, 1, "confidence")[:50].any()


def test_unsure_points_are_left_out(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    apply(workspace, classifier=made.id, frames="1", above=0.9)
    some = layer(workspace, 1) > 0
    assert 0 < some.mean() < 1
    assert layer(workspace, 1, "confidence")[some].min() >= 0.85 * 255
    apply(workspace, classifier=made.id, frames="1", above=None)
    assert made.above == 0.5  # too few places to measure
    assert layer(workspace, 1, "confidence")[layer(workspace, 1) > 0].min() >= 0.5 * 255


def test_locked_and_hidden_classes_get_no_points(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    workspace.labels.update_label("room", "me", WALL, locked=True)
    workspace.labels.update_label("room", "me", FLOOR, visible=False)
    assert apply(workspace, classifier=made.id, frames="1")["changed"] == 0


def test_a_recording_without_the_labels_gets_them(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    assert not workspace.classifiers.predict(made.id, "other", 0).label.any()
    job = workspace.predictions.start("other", Application(made.id, "0"), "me")
    assert workspace.runner.wait(job.id, 60).state == "done"
    assert [label.name for label in workspace.labels.palette("other")] == ["floor", "wall"]
    workspace.labels.undo("other", "me")
    assert not workspace.annotations.read("other", 0)[0].any()


def test_two_people_teach_one_and_every_stroke_counts(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    before = workspace.classifiers.about(made.id).examples["wall"]
    both = [
        threading.Thread(
            target=paint, args=(workspace, frame, np.r_[FLAT + 200 : FLAT + 400], WALL)
        )
        for frame in (0, 1)
    ]
    for each in both:
        each.start()
    for each in both:
        each.join()
    workspace.classifiers.predict(made.id, "room", 1)
    assert workspace.classifiers.about(made.id).examples["wall"] > 1.5 * before


def test_one_made_before_the_first_stroke_learns_from_it(workspace: Workspace) -> None:
    for _ in range(2):
        workspace.labels.undo("room", "me")
    made = workspace.classifiers.create("early", ["room"])
    assert not workspace.classifiers.predict(made.id, "room", 0).kind.any()
    assert made.taught_by == {"room": 0}
    paint(workspace, 1, np.r_[0:200], FLOOR)
    assert (workspace.classifiers.predict(made.id, "room", 0).label == FLOOR).all()


def test_doubt_leads_to_what_is_not_painted(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    places = workspace.classifiers.doubt(made.id, "room", most=3)
    assert 1 <= len(places) <= 3
    assert set(places[0].classes) <= {"floor", "wall"}
    xyz = workspace.recording("room")[places[0].frame].source_xyz()
    assert np.linalg.norm(xyz - places[0].centre, axis=1).min() < 0.2
    assert {p.sequence for p in workspace.classifiers.doubt(made.id, "room", workspace=True)}


def test_a_classifier_goes_and_comes_as_a_file(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    data = workspace.classifiers.file(made.id)
    workspace.classifiers.delete(made.id)
    assert not workspace.classifiers.listing()
    with pytest.raises(NotFoundError, match="classifier"):
        workspace.classifiers.predict(made.id, "room", 0)
    brought = workspace.classifiers.import_file(data, "again")
    found = workspace.classifiers.predict(brought.id, "room", 0).label
    assert set(found.tolist()) == {FLOOR, WALL}


def test_what_was_taught_outlives_the_server(workspace: Workspace) -> None:
    made = workspace.classifiers.create("rooms", ["room"])
    workspace.close()
    with closing(Workspace(workspace.settings)) as again:
        assert again.classifiers.about(made.id) == made
        assert again.classifiers.predict(made.id, "room", 0).label.any()


def test_unsure_predictions_are_suspicious_until_somebody_vouches(workspace: Workspace) -> None:
    numbers = np.arange(FLAT + TALL)
    write = Write(numbers, label=FLOOR, provenance=PREDICTED, confidence=np.uint8(40))
    workspace.labels.apply(
        "room", edit_id=None, author="me", kind="prediction", writes={1: write}, summary="-"
    )
    found = workspace.reviewing.checks("room").findings
    assert [(each.first, each.labels) for each in found if each.kind == "predicted"] == [
        (1, (FLOOR,))
    ]
    workspace.verdicts.give("accept", "room", [1], [FLOOR], "me", None)
    found = workspace.reviewing.checks("room").findings
    assert not [each for each in found if each.kind == "predicted"]
    assert (layer(workspace, 1, "provenance") == PAINTED).all()


class Floors:
    """A plug-in that knows floors and walls by height, whatever is painted."""

    takes, classes, learns = "points", ("floor", "wall"), False

    def scores(self, question: Question) -> NDArray[np.float32]:
        tall = (question.points.xyz[:, 2] > 0.1).astype(np.float32)
        return np.stack([1 - tall, tall], axis=1)


def test_a_model_of_ones_own_answers_in_place_of_trees(
    workspace: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    group = "pointbrush.classifiers"
    entries = (EntryPoint("floors", f"{__name__}:Floors", group),)
    monkeypatch.setattr(model_names, "entry_points", lambda **_: entries)
    with pytest.raises(BadInputError, match="model: expected one of floors"):
        workspace.classifiers.create("rooms", ["room"], model="other")
    made = workspace.classifiers.create("network", ["room"], model="floors")
    assert (made.model, made.classes) == ("floors", ("floor", "wall"))
    found = workspace.classifiers.predict(made.id, "room", 1)
    right = (workspace.recording("room")[1].to_source(found.label) == WALL) == IS_WALL
    assert right.mean() > 0.95
    again = workspace.classifiers.import_file(workspace.classifiers.file(made.id))
    assert again.model == "floors"
    assert workspace.classifiers.doubt(made.id, "room")
    recording, known = workspace.recording("room"), workspace.classifiers.current(made.id)
    own = workspace.classifiers.models.make("floors")
    applied, _ = next(predict_frame(recording, 1, known, workspace.classifiers.options, own))
    assert np.array_equal(applied.kind.values(), found.kind)


def test_imported_labels_teach_where_that_is_chosen(workspace: Workspace) -> None:
    paint(workspace, 1, np.r_[0:300], FLOOR, IMPORTED)
    paint(workspace, 1, np.r_[FLAT : FLAT + 300], WALL, IMPORTED)
    alone = workspace.classifiers.create("painted", ["room"])
    both = workspace.classifiers.create("both", ["room"], imported=True)
    assert both.examples["wall"] > 1.5 * alone.examples["wall"]
    apply(workspace, classifier=both.id, frames="0")
    workspace.classifiers.predict(both.id, "room", 0)  # what was predicted teaches nothing
    assert workspace.classifiers.about(both.id).examples == both.examples


def test_what_stands_still_agrees_with_the_taught_frame(workspace: Workspace) -> None:
    recording = workspace.recording("room")
    manifest = recording.manifest
    moved = np.eye(4)
    moved[:3, 3] = 0.5, 0.0, 0.0
    there = replace(manifest, poses=(tuple(np.eye(4).ravel()), tuple(moved.ravel())))
    seen = SimpleNamespace(manifest=there)
    centre = np.array([[0.0, 0, 0], [1.0, 0, 0], [9.0, 0, 0]], np.float32)
    none = np.empty(0, np.int32)
    features = np.empty((3, 0), np.float32)
    near = np.empty((3, 26), np.int32)
    place = Described(0.1, none, centre, near, features, none)
    half = np.full((3, 2), 0.5, np.float32)
    taught = Described(0.1, none, centre + np.float32([0.5, 0, 0]), near, features, none)
    said = np.array([[0.9, 0.1], [0.1, 0.9], [0.9, 0.1]], np.float32)
    out = average_chances(seen, 1, place, half, 0, lambda _: (taught, said))  # type: ignore[arg-type]
    assert np.allclose(out[:, 0], [0.7, 0.3, 0.7])
    far = Described(0.1, none, centre + np.float32([1.0, 0, 0]), near, features, none)
    out = average_chances(seen, 1, place, half, 0, lambda _: (far, said))  # type: ignore[arg-type]
    assert np.allclose(out[[0, 2]], half[[0, 2]])
    taught_by = {("room", 0): None, ("room", 1): None}
    known = Classifier("a", ("a",), examples=taught_by)  # type: ignore[arg-type]
    assert voter_of(known, recording, 1, 10**6) is None  # which has no poses


def test_large_frames_are_taught_and_asked_in_parts(workspace: Workspace, tmp_path: Path) -> None:
    every = FLAT + TALL
    few = ClassifierOptions(
        whole_points=1000, view_points=every, taught_points=every, piece_points=2000
    )
    ids = workspace.library.ids
    known = Classifiers(workspace.labels, tmp_path / "few", workspace.recording, ids, few)
    made = known.create("parts", ["room"])
    assert all(made.examples.values())
    with pytest.raises(TooLargeError, match="a place in it"):
        known.predict(made.id, "room", 1)
    near = known.predict(made.id, "room", 1, place=[1.5, 1.5, 0.5])
    assert near.numbers is None or (np.diff(near.numbers) > 0).all()
    assert known.doubt(made.id, "room", frame=1, near=[1.5, 1.5, 0.5])
    recording, label = workspace.recording("room"), np.zeros(every, np.uint8)
    for found, _ in predict_frame(recording, 1, known.current(made.id), few):
        assert found.numbers is not None
        label[found.numbers] = found.kind.values()
    assert ((recording[1].to_source(label) == WALL) == IS_WALL).mean() > 0.95


def test_classes_of_a_classifier_are_renamed_and_merged_with_the_workspaces(
    workspace: Workspace,
) -> None:
    store = workspace.labels
    for label, name in ((FLOOR, "ground"), (WALL, "house")):
        store.update_label("room", "me", label, category=name)
    store.create_label("room", "me", name="door", category="house part")
    paint(workspace, 0, np.r_[FLAT + 900 : FLAT + 1000], 3)
    made = workspace.classifiers.create("rooms", ["room"])
    assert made.classes == ("ground", "house", "house part")
    numbers = store.taxonomy.numbers(made.classes)
    elsewhere = workspace.classifiers.file(made.id)
    store.taxonomy.put([Category(numbers["house"], "building")])
    store.taxonomy.merge(numbers["house"], [numbers["house part"]])
    brought = workspace.classifiers.import_file(elsewhere, "brought").id
    again = Classifiers(
        store, workspace._classifier_folder, workspace.recording, workspace.library.ids
    )
    for service, identifier in (
        (workspace.classifiers, made.id), (workspace.classifiers, brought), (again, made.id),
    ):  # fmt: skip
        about = service.about(identifier)
        assert about.classes == ("ground", "building")
        assert sum(about.examples.values()) == sum(made.examples.values())
        found = service.predict(identifier, "room", 0)
        stored = workspace.recording("room")[0]
        right = (stored.to_source(found.label) == WALL) == IS_WALL
        assert right.mean() > 0.97
    apply(workspace, classifier=made.id, frames="1")
    assert {label.category for label in store.palette("room")} == {"ground", "building"}
