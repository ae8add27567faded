"""The object tool on the server: clicks → candidates → one edit."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from serving import settings_in

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.work.objects.service import Answer, StaleCandidateError
from pointbrush.workspace import Workspace
from tests.waiting import eventually

SEQUENCE = "balls"
FLOOR, BALL = 6000, 1500
BALLS = ((-0.5, 0.25, 2.0), (0.5, 0.25, 2.0))


def ball_frame(seed: int) -> PointFrame:
    """A floor below two balls with a gap under each; y up, seen from the origin."""
    rng = np.random.default_rng(seed)
    floor = np.column_stack(
        [rng.uniform(-1.5, 1.5, FLOOR), np.zeros(FLOOR), rng.uniform(0.8, 3.5, FLOOR)]
    )
    parts = [floor]
    for middle in BALLS:
        way = rng.normal(size=(BALL, 3))
        parts.append(0.15 * way / np.linalg.norm(way, axis=1, keepdims=True) + middle)
    rgb = np.repeat(
        np.array([[90, 90, 90], [200, 40, 40], [40, 40, 200]], np.uint8),
        [FLOOR, BALL, BALL],
        axis=0,
    )
    return PointFrame(np.concatenate(parts).astype(np.float32), rgb)


def empty_frame() -> PointFrame:
    return PointFrame(np.empty((0, 3), np.float32), np.empty((0, 3), np.uint8))


@pytest.fixture
def workspace(tmp_path: Any) -> Iterator[Workspace]:
    settings = settings_in(tmp_path)
    import_frames(
        iter([ball_frame(0), ball_frame(1), empty_frame()]),
        settings.workspace / "sequences" / SEQUENCE,
        RecordingInfo(SEQUENCE, SEQUENCE, 10),
    )
    opened = Workspace(settings)
    opened.labels.create_label(SEQUENCE, "ada", name="one")
    opened.labels.create_label(SEQUENCE, "ada", name="two")
    yield opened
    opened.close()


def ray(at: tuple[float, float, float]) -> dict[str, list[float]]:
    """A ray from the origin's height to a place."""
    origin = np.array([at[0], at[1], 0.0])
    way = np.array(at) - origin
    return {"origin": origin.tolist(), "direction": (way / np.linalg.norm(way)).tolist()}


def ask(workspace: Workspace, frame: int = 0, **fields: Any) -> Answer:
    return workspace.strokes.preview(
        SEQUENCE, frame, {"positives": [ray(BALLS[0])], "label": 1, **fields}
    )


def take(workspace: Workspace, frame: int = 0, **fields: Any) -> Any:
    stroke = {"shape": "object", "label": 1, "samples": [ray(BALLS[0])], **fields}
    return workspace.strokes.apply(SEQUENCE, frame, stroke, "ada")


def label(workspace: Workspace, frame: int = 0) -> NDArray[np.uint16]:
    return workspace.annotations.read(SEQUENCE, frame)[0]


def painted_stored(workspace: Workspace, number: int) -> NDArray[np.int64]:
    """Stored numbers of the points of a label in frame 0."""
    source_index = workspace.recording(SEQUENCE)[0].source_index
    return np.flatnonzero(label(workspace)[source_index] == number)


def ready(workspace: Workspace, frame: int = 0) -> Answer:
    """The answer once the frame is prepared."""
    eventually(lambda: ask(workspace, frame).ready, every=0.1)
    return ask(workspace, frame)


def overlap(numbers: NDArray[np.int64], workspace: Workspace, ball: int = 0) -> float:
    source = workspace.recording(SEQUENCE)[0].source_index[numbers]
    mine = np.arange(FLOOR + ball * BALL, FLOOR + (ball + 1) * BALL)
    return len(np.intersect1d(source, mine)) / len(np.union1d(source, mine))


def test_a_click_offers_the_ball_before_and_after_the_frame_is_prepared(
    workspace: Workspace,
) -> None:
    for answer in (ask(workspace), ready(workspace)):
        assert 1 <= len(answer.candidates) <= 6
        sizes = [len(each.numbers) for each in answer.candidates]
        assert sizes == sorted(sizes)
        assert max(overlap(each.numbers, workspace) for each in answer.candidates) > 0.95


def test_a_prepared_frame_stays_prepared_for_another_server(
    workspace: Workspace,
) -> None:
    ready(workspace)
    workspace.close()
    again = Workspace(workspace.settings)
    assert ask(again).ready
    again.close()


def test_a_prepared_frame_with_a_changed_number_is_prepared_anew(workspace: Workspace) -> None:
    before = ready(workspace)
    workspace.close()
    for path in workspace.settings.workspace.glob("objects/*/*/*.npz"):
        with np.load(path) as stored:
            arrays = {name: stored[name].copy() for name in stored}
        arrays["piece"][0] = 2**31 - 1
        np.savez(path, **arrays)
    with closing(Workspace(workspace.settings)) as again:
        assert not ask(again).ready
        assert [one.id for one in ready(again).candidates] == [one.id for one in before.candidates]


def test_taking_a_candidate_is_one_edit_that_one_undo_takes_back(workspace: Workspace) -> None:
    answer = ask(workspace)
    chosen = answer.candidates[answer.first]
    commit = take(workspace, candidate=chosen.id)
    assert commit.changed == len(chosen.numbers)
    assert (np.flatnonzero(label(workspace)) >= FLOOR).all()
    workspace.labels.undo(SEQUENCE, "ada")
    assert not label(workspace).any()


def test_a_stroke_sent_twice_is_applied_once(workspace: Workspace) -> None:
    first = ask(workspace)
    stroke = {"id": str(uuid.uuid4()), "candidate": first.candidates[first.first].id}
    assert take(workspace, **stroke).revision == take(workspace, **stroke).revision


def test_a_level_alone_is_enough_for_scripts(workspace: Workspace) -> None:
    levels = len(ask(workspace).candidates)
    take(workspace, level=0)
    with pytest.raises(BadInputError, match=f"level: expected 0 to {levels - 1}"):
        take(workspace, level=5) if levels < 6 else take(workspace, level=6)


def test_a_stale_candidate_is_refused_with_fresh_ones(workspace: Workspace) -> None:
    answer = ask(workspace)
    other = {"shape": "sphere", "label": 2, "radius": 0.1, "samples": [{"origin": list(BALLS[0])}]}
    workspace.strokes.apply(SEQUENCE, 0, {**other, "radius": 0.2}, "bob")
    with pytest.raises(StaleCandidateError) as caught:
        take(workspace, candidate=answer.candidates[answer.first].id)
    assert caught.value.answer.candidates == ()  # all of it is bob's by now
    assert not (label(workspace) == 1).any()


def test_a_candidate_asked_for_without_a_label_is_painted_with_any(workspace: Workspace) -> None:
    answer = ask(workspace, label=0)
    chosen = answer.candidates[answer.first]
    ready(workspace)  # an answer from the prepared frame is another one
    take(workspace, candidate=chosen.id, label=2)
    assert np.array_equal(np.sort(chosen.numbers), painted_stored(workspace, 2))


def test_a_candidate_of_another_label_does_not_repaint_its_points(workspace: Workspace) -> None:
    take(workspace, label=2)
    answer = ask(workspace, label=2)
    assert take(workspace, candidate=answer.candidates[0].id, label=1).changed == 0
    assert take(workspace, candidate=answer.candidates[0].id, take_labelled=True).changed > 0


def test_a_stroke_in_another_frame_leaves_candidates_valid(workspace: Workspace) -> None:
    answer = ask(workspace)
    other = {"shape": "sphere", "label": 2, "radius": 0.2, "samples": [{"origin": list(BALLS[0])}]}
    workspace.strokes.apply(SEQUENCE, 1, other, "bob")
    assert take(workspace, candidate=answer.candidates[answer.first].id).changed > 0


def test_points_of_other_labels_are_left_alone_unless_asked(workspace: Workspace) -> None:
    half = {"shape": "sphere", "label": 2, "radius": 0.12, "samples": [ray(BALLS[0])]}
    half["samples"] = [{"origin": [BALLS[0][0], BALLS[0][1] + 0.1, BALLS[0][2]]}]
    workspace.strokes.apply(SEQUENCE, 0, half, "bob")
    theirs = label(workspace) == 2
    assert theirs.any()
    take(workspace)
    assert (label(workspace)[theirs] == 2).all()
    take(workspace, take_labelled=True)
    assert (label(workspace)[theirs] == 1).all()


def test_hidden_locked_and_deleted_points_are_never_taken(workspace: Workspace) -> None:
    part = {"label": 2, "radius": 0.12, "shape": "sphere"}
    part["samples"] = [{"origin": [BALLS[0][0], BALLS[0][1] + 0.1, BALLS[0][2]]}]  # type: ignore[assignment]
    workspace.strokes.apply(SEQUENCE, 0, part, "bob")
    theirs = label(workspace) == 2
    for change in ({"locked": True}, {"locked": False, "visible": False}):
        workspace.labels.update_label(SEQUENCE, "bob", 2, **change)
        take(workspace, take_labelled=True)
        assert (label(workspace)[theirs] == 2).all()
        workspace.labels.undo(SEQUENCE, "ada")
    workspace.labels.update_label(SEQUENCE, "bob", 2, visible=True)
    take(workspace, take_labelled=True, hidden=[2])
    assert (label(workspace)[theirs] == 2).all()


def test_a_refined_object_takes_the_place_of_the_first_and_stays_one_undo(
    workspace: Workspace,
) -> None:
    first = ask(workspace)
    one = take(workspace, candidate=first.candidates[first.first].id)
    both = {"positives": [ray(BALLS[0]), ray(BALLS[1])], "label": 1}
    answer = workspace.strokes.preview(SEQUENCE, 0, both)
    stroke = {
        "samples": both["positives"],
        "candidate": answer.candidates[answer.first].id,
        "replaces": one.edit,
        "id": str(uuid.uuid4()),
    }
    take(workspace, **stroke)
    painted = np.flatnonzero(label(workspace) == 1)
    assert np.isin(np.arange(FLOOR, FLOOR + 2 * BALL), painted).mean() > 0.9
    workspace.labels.undo(SEQUENCE, "ada")
    assert not label(workspace).any()


def test_only_the_last_edit_can_be_replaced(workspace: Workspace) -> None:
    one = take(workspace)
    workspace.labels.create_label(SEQUENCE, "ada", name="three")
    with pytest.raises(ConflictError, match="replaces: expected your last edit"):
        take(workspace, replaces=one.edit)


def test_a_clip_box_bounds_an_object(workspace: Workspace) -> None:
    xyz = workspace.recording(SEQUENCE)[0].xyz
    half = {"center": [BALLS[0][0], BALLS[0][1], BALLS[0][2]], "size": [0.15, 4.0, 4.0]}
    answer = ask(workspace, clip=half)
    whole = ask(workspace)
    assert answer.candidates
    for level in answer.candidates:
        assert (np.abs(xyz[level.numbers][:, 0] - BALLS[0][0]) <= 0.075 + 1e-6).all()
    assert max(len(each.numbers) for each in answer.candidates) < max(
        len(each.numbers) for each in whole.candidates
    )
    elsewhere = {"center": [50, 50, 50], "size": [1, 1, 1]}
    assert not ask(workspace, clip=elsewhere).candidates


def test_a_negative_click_stays_out(workspace: Workspace) -> None:
    both = [ray(BALLS[0])]
    answer = ask(workspace, positives=both, negatives=[ray(BALLS[1])])
    for each in answer.candidates:
        assert overlap(each.numbers, workspace, ball=1) < 0.01


def test_an_empty_frame_and_a_ray_past_everything_offer_nothing(workspace: Workspace) -> None:
    assert ask(workspace, frame=2).candidates == ()
    away = {"origin": [0.0, 5.0, 0.0], "direction": [0.0, 1.0, 0.0]}
    assert ask(workspace, positives=[away]).candidates == ()
    with pytest.raises(BadInputError, match="meets the frame"):
        take(workspace, samples=[away])


def test_too_many_clicks_are_refused(workspace: Workspace) -> None:
    with pytest.raises(BadInputError, match="at most 64"):
        ask(workspace, positives=[ray(BALLS[0])] * 65)


@pytest.mark.parametrize("shape", ["grow", "cluster", "plane"])
def test_the_preview_of_a_region_is_what_a_stroke_changes(workspace: Workspace, shape: str) -> None:
    # The ground is no cluster: there it is a ball.
    at = [0.5, 1.0, 2.0] if shape == "cluster" else [0.9, 1.0, 1.0]
    down = {"origin": at, "direction": [0.0, -1.0, 0.0]}
    fields = {"shape": shape, "label": 1, "radius": 0.1}
    [level] = workspace.strokes.preview(SEQUENCE, 0, {**fields, "positives": [down]}).candidates
    assert workspace.strokes.apply(
        SEQUENCE, 0, {**fields, "samples": [down]}, "ada"
    ).changed == len(level.numbers)
