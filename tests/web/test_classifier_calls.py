"""Labels by example over REST and by the client: taught, predicted, applied, taken elsewhere."""

from __future__ import annotations

import asyncio
import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.client import AsyncClient, Client, HeldOut, Place, Recording
from pointbrush.errors import BadInputError, ForbiddenError, NotFoundError
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.serving import Served, serving, settings_in

FLAT, TALL = 2000, 1000
IS_WALL = np.arange(FLAT + TALL) >= FLAT
PREDICTED = 4


def scene(seed: int) -> PointFrame:
    rng = np.random.default_rng(seed)
    floor = np.column_stack([rng.uniform(0, 3, (FLAT, 2)), rng.normal(0, 0.005, FLAT)])
    wall = np.column_stack([rng.uniform(0, 3, TALL), np.full(TALL, 3.0), rng.uniform(0, 2, TALL)])
    return PointFrame(np.concatenate([floor, wall]).astype(np.float32))


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    settings = settings_in(tmp_path_factory.mktemp("served"))
    folder = settings.workspace / "sequences" / "hall"
    folder.parent.mkdir(parents=True)
    import_frames([scene(0), scene(1)], folder, RecordingInfo("hall", "hall", 1.0))
    yard = folder.with_name("yard")
    import_frames([scene(2)], yard, RecordingInfo("yard", "yard", 1.0))
    with serving(settings) as running:
        yield running


@pytest.fixture(scope="module")
def client(served: Served) -> Iterator[Client]:
    with Client(served.url, served.token) as opened:
        hall = opened["hall"]
        for name in ("floor", "wall"):
            hall.create_label(name)
        painted = np.zeros(FLAT + TALL, np.uint16)
        painted[:200], painted[FLAT : FLAT + 200] = 1, 2
        hall.frames[0].annotate(painted)
        hall.frames[0].annotate((painted > 0).astype(np.uint8), "provenance")
        yield opened


@pytest.fixture
def hall(client: Client) -> Recording:
    return client["hall"]


def test_a_classifier_predicts_and_labels(client: Client, hall: Recording) -> None:
    made = client.classifiers.create("halls", ["hall"])
    assert made.classes == ("floor", "wall")
    found = hall.by_example.predict(made.id, 1)
    assert found.index is None
    assert ((found.label == 2) == IS_WALL).mean() > 0.97
    assert found.classes[found.kind[0] - 1] == "floor"
    places = hall.by_example.doubt(made.id, most=2)
    assert places[0].radius > 0
    near = hall.by_example.doubt(made.id, frame=0, near=[1.5, 1.5, 0.0], most=1)
    assert near[0].frame == 0
    result = hall.by_example.apply(made.id, "1", 0.2)
    assert result.changed > 0
    values = hall.frames[1].annotation("provenance")
    assert set(np.unique(values)) <= {0, PREDICTED}
    assert hall.frames[1].annotation("confidence").max() > 128
    hall.undo()
    assert not hall.frames[1].annotation().any()


def numbers(place: Place) -> NDArray[np.int64]:
    return np.concatenate([np.arange(first, first + length) for first, length in place.runs])


def test_none_of_the_classes_is_neither_asked_nor_predicted_again(
    client: Client, hall: Recording
) -> None:
    made = client.classifiers.create("nones", ["hall"])
    place = hall.by_example.doubt(made.id, frame=1, most=1)[0]
    piece = numbers(place)
    assert len(piece) == place.points
    assert hall.by_example.predict(made.id, 1).kind[piece].all()
    hall.by_example.ignore(made.id, place)
    found = hall.by_example.predict(made.id, 1)
    assert not found.kind[piece].any()
    assert found.kind.any()
    for other in hall.by_example.doubt(made.id, frame=1, most=5):
        assert not np.isin(numbers(other), piece).any()
    hall.by_example.apply(made.id, "1", 0.0)
    labels = hall.frames[1].annotation()
    assert labels.any()
    assert not labels[piece].any()
    hall.undo()
    saved = client.call("GET", f"/classifiers/{made.id}/file").content
    with np.load(io.BytesIO(saved)) as arrays:
        about = json.loads(arrays["about"].tobytes())
    assert about["ignored"] == []  # a file for other workspaces has no places
    hall.by_example.take_back(made.id)
    assert hall.by_example.predict(made.id, 1).kind[piece].all()
    with pytest.raises(NotFoundError):
        hall.by_example.take_back(made.id)
    client.classifiers.delete(made.id)


def test_an_answer_paints_the_piece_and_no_other_point(client: Client, hall: Recording) -> None:
    made = client.classifiers.create("answers", ["hall"])
    place = hall.by_example.doubt(made.id, frame=1, most=1)[0]
    assert hall.by_example.answer(made.id, place, label=2) == place.points
    labels = hall.frames[1].annotation()
    assert np.array_equal(np.flatnonzero(labels), numbers(place))
    for other in hall.by_example.doubt(made.id, frame=1, most=5):
        assert not np.isin(numbers(other), numbers(place)).any()
    hall.undo()
    assert not hall.frames[1].annotation().any()
    client.classifiers.delete(made.id)


def test_a_skipped_place_is_predicted_but_not_asked_again(client: Client, hall: Recording) -> None:
    made = client.classifiers.create("skips", ["hall"])
    place = hall.by_example.doubt(made.id, frame=1, most=1)[0]
    hall.by_example.ignore(made.id, place, skip=True)
    assert hall.by_example.predict(made.id, 1).kind[numbers(place)].all()
    later = hall.by_example.doubt(made.id, frame=1, most=5)
    for other in later:
        assert not np.isin(numbers(other), numbers(place)).any()
    hall.by_example.ignore(made.id, later[0])
    hall.by_example.take_back(made.id, place)  # the later answer stays
    assert not hall.by_example.predict(made.id, 1).kind[numbers(later[0])].any()
    with pytest.raises(NotFoundError):
        hall.by_example.take_back(made.id, place)
    client.classifiers.delete(made.id)


def test_a_page_gets_points_as_it_holds_them(client: Client, hall: Recording) -> None:
    made = client.classifiers.create("stored", ["hall"])
    path = "/sequences/hall/frames/1/prediction?format=stored"
    data = client.call("POST", path, json={"classifier": made.id}).content
    size = int.from_bytes(data[:4], "little")
    told = json.loads(data[4 : 4 + size])
    n = told["points"]
    assert (n, told["part"], told["labels"]) == (FLAT + TALL, False, [1, 2])
    assert (4 + size) % 4 == 0
    kind = np.frombuffer(data, np.uint8, n, 4 + size)
    assert len(data) == 4 + size + 2 * n
    assert (
        np.bincount(kind)[1:].tolist()
        == np.bincount(hall.by_example.predict(made.id, 1).kind)[1:].tolist()
    )


def test_what_is_near_a_place_is_predicted_alone(client: Client, hall: Recording) -> None:
    made = client.classifiers.create("near", ["hall"])
    near = hall.by_example.predict(made.id, 0, place=[1.5, 1.5, 0.0])
    assert 0 < len(near.kind) <= FLAT + TALL
    far = hall.by_example.predict(made.id, 0, place=[0.05, -4.5e9, 0.0])
    assert len(far.kind) <= FLAT + TALL


def test_a_classifier_is_taken_elsewhere(client: Client, hall: Recording, tmp_path: Path) -> None:
    made = client.classifiers.create("taken", ["hall"], ["floor", "wall"])
    file = client.classifiers.save(made.id, tmp_path / "taken.npz")
    client.classifiers.delete(made.id)
    with pytest.raises(NotFoundError):
        client.classifiers[made.id]
    again = client.classifiers.load(file, "brought")
    assert again.name == "brought"
    assert again.id in {each.id for each in client.classifiers.all()}
    assert hall.by_example.predict(again.id, 0, labels=[1]).label.max() == 1
    file.write_bytes(b"rubbish")
    with pytest.raises(BadInputError, match="classifier"):
        client.classifiers.load(file)


def test_a_classifier_starts_from_labels_of_other_recordings(client: Client) -> None:
    yard = client["yard"]
    assert yard.by_example.starts() == {"hall": ("floor", "wall")}
    made = client.classifiers.create("yards", ["yard"], start_from=["hall"])
    assert made.start_from == ("hall",)
    assert made.taught_by == {"yard": 0}
    assert made.held_out["wall"] == HeldOut(None, 0)
    assert made.above == 0.5
    found = yard.by_example.predict(made.id, 0)
    assert ((found.kind == 2) == IS_WALL).mean() > 0.97


def test_exports_leave_out_what_is_unsure(client: Client, hall: Recording, tmp_path: Path) -> None:
    made = client.classifiers.create("exported", ["hall"])
    hall.by_example.apply(made.id, "1", 0.0)
    sure = hall.frames[1].annotation("confidence")
    hall.export("npz", tmp_path / "all.zip", "1")
    hall.export("npz", tmp_path / "some.zip", "1", above=0.9)
    assert (sure < 0.9 * 255).any()
    counts = [_labelled(tmp_path / name) for name in ("all.zip", "some.zip")]
    assert counts == [len(sure), int((sure >= 0.9 * 255).sum())]
    hall.undo()


def _labelled(path: Path) -> int:
    with zipfile.ZipFile(path) as archive, archive.open("000001.npz") as member:
        return int((np.load(io.BytesIO(member.read()))["label"] > 0).sum())


def test_roles_are_those_of_tracking(served: Served, client: Client) -> None:
    made = client.classifiers.create("shared", ["hall"])
    for role, may in (("viewer", False), ("annotator", True)):
        token = served.workspace.labels.tokens.add(role, f"a {role}")
        with Client(served.url, token) as other:
            assert other.classifiers[made.id].name == "shared"
            if may:
                assert other["hall"].by_example.predict(made.id, 0).label.any()
            else:
                with pytest.raises(ForbiddenError):
                    other["hall"].by_example.predict(made.id, 0)
            with pytest.raises(ForbiddenError):
                other.classifiers.delete(made.id)


def test_coroutines_do_the_same(served: Served, client: Client) -> None:
    made = client.classifiers.create("awaited", ["hall"])

    async def predicted() -> int:
        async with AsyncClient(served.url, served.token) as other:
            hall = await other["hall"]
            await other.classifiers.teach(made.id)
            return len((await hall.by_example.predict(made.id, 0)).label)

    assert asyncio.run(predicted()) == FLAT + TALL
