"""People are found in the pictures of a depth camera, previewed, and labelled as one edit."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from pointbrush.cli import main
from pointbrush.client import AsyncClient, Client, FoundPerson, Recording
from pointbrush.errors import ConflictError
from pointbrush.frame import PointFrame
from pointbrush.masks.people import model
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.samples import generate
from pointbrush.samples.recording import Recording as Sample
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence
from pointbrush.sequences.storage.recording_files import FolderFiles
from pointbrush.work.people.frames import Search
from tests.serving import TOKEN, Served, add_sequence, serving, settings_in

pytest.importorskip("ai_edge_litert")

SEED, FRAMES, APART = 31, 2, 40
"""A seed on which nothing was tuned; two frames that are far apart in time."""
JUGGLERS = (7, 8)
FURNITURE_SEED = 200
"""Of a room in which furniture looks like a person in one picture."""
SHIPPED = Path(__file__).parents[2] / "data" / "juggling"
PAINTED, PREDICTED = 1, 4


@pytest.fixture(scope="module")
def sample() -> Sample:
    return generate("juggling", SEED, APART + 1)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, sample: Sample) -> Iterator[Served]:
    settings = settings_in(tmp_path_factory.mktemp("served"))
    for name, frames in (("room", (0, APART)), ("once", (0,)), ("still", ())):
        folder = settings.workspace / "sequences" / name
        made = [sample.frame(i) for i in frames] or [without_people(sample)]
        import_frames(iter(made), folder, RecordingInfo(name, name, 30.0))
    add_sequence(settings, "wall", frames=1)
    with serving(settings) as running:
        yield running


def without_people(sample: Sample, index: int = 0) -> PointFrame:
    """Return the furnished room with the labelled points left out."""
    frame, keep = sample.frame(index), sample.truth[index] == 0
    assert frame.rgb is not None
    assert frame.pixel is not None
    columns = {name: getattr(frame, name)[keep] for name in ("xyz", "rgb", "pixel")}
    return PointFrame(**columns, camera=frame.camera, viewpoint=frame.viewpoint)


@pytest.fixture
def client(served: Served) -> Iterator[Client]:
    with Client(served.url, TOKEN) as opened:
        yield opened


def overlap(numbers: NDArray[np.int64], truth: NDArray[np.bool_]) -> float:
    """Return the intersection of points over their union."""
    mask = np.zeros(len(truth), np.bool_)
    mask[numbers] = True
    return float((mask & truth).sum() / (mask | truth).sum())


def matched(people: tuple[FoundPerson, ...], sample: Sample, frame: int, shown: int) -> list[float]:
    """Return the best overlap of each juggler with a person in a frame."""
    truth = sample.truth[frame]
    points = [each.numbers for person in people for each in person.frames if each.frame == shown]
    return [max(overlap(numbers, truth == one) for numbers in points) for one in JUGGLERS]


def test_both_jugglers_and_nothing_else_are_found(client: Client, sample: Sample) -> None:
    found = client["room"].find_people()
    assert found.searched == FRAMES
    assert found.category == "person"
    assert {person.name for person in found.people} == {"person 1", "person 2"}
    for shown, frame in enumerate((0, APART)):
        # A pin in a hand is labelled with its juggler, which costs a twentieth.
        assert min(matched(found.people, sample, frame, shown)) > 0.87
    # The same person in both frames is one person.
    assert [[each.frame for each in person.frames] for person in found.people] == [[0, 1]] * 2
    assert client["room"].labels() == []


def test_a_room_without_people_gets_no_label(client: Client) -> None:
    assert client["still"].find_people().people == ()
    assert client["still"].label_people().edit is None
    assert client["still"].labels() == []


def test_the_shipped_sample_shows_two_people(tmp_path: Path) -> None:
    workspace = tmp_path / "workspace"
    assert main(["import", str(SHIPPED), "--workspace", str(workspace)]) == 0
    recording = open_sequence(FolderFiles(workspace / "sequences" / "juggling"))
    search = Search(recording, model.PersonModel(), PeopleOptions())
    assert [len(search.people_in(frame)) for frame in range(len(recording))] == [2] * len(recording)


def test_furniture_that_rests_over_a_recording_gets_no_label(tmp_path: Path) -> None:
    sample, folder = generate("juggling", FURNITURE_SEED, 90), tmp_path / "rested"
    frames = (without_people(sample, frame) for frame in (5, 45))
    import_frames(frames, folder, RecordingInfo("rested", "rested", 1.0))
    recording = open_sequence(FolderFiles(folder))
    search = Search(recording, model.PersonModel(), PeopleOptions())
    assert [search.people_in(frame) for frame in range(len(recording))] == [[], []]


def test_people_are_labelled_as_one_edit_and_painted_points_win(
    client: Client, sample: Sample
) -> None:
    room = client["once"]
    mine = room.create_label("chair")
    truth = np.flatnonzero(np.isin(sample.truth[0], JUGGLERS))
    painted = np.zeros(len(sample.truth[0]), np.uint16)
    painted[truth[:500]] = mine.id
    room.frames[0].annotate(painted)
    room.frames[0].annotate((painted > 0).astype(np.uint8), "provenance")
    shown = room.find_people([0]).people
    done = room.label_people([0])
    assert done.people == len(shown) == 2
    label, came = (room.frames[0].annotation(layer) for layer in ("label", "provenance"))
    assert (label[truth[:500]] == mine.id).all()
    people = {each.name: each.id for each in room.labels() if each.category == "person"}
    for person in shown:
        numbers = person.frames[0].numbers
        free = numbers[painted[numbers] == 0]
        assert (label[free] == people[person.name]).all()
        assert (came[free] == PREDICTED).all()
    # A second search knows them.
    assert {each.label for each in room.find_people([0]).people} == set(people.values())
    assert room.label_people([0]).changed == 0
    room.undo()
    assert {each.name for each in room.labels()} == {"chair"}
    assert (room.frames[0].annotation() == painted).all()


def test_runs_are_in_the_order_that_a_page_has(served: Served, client: Client) -> None:
    place = f"{served.url}/api/v1/sequences/room/people"
    body = {"frames": [0]}
    answer = httpx.post(f"{place}?format=stored", json=body, headers=served.headers).json()
    stored = served.workspace.recording("room")[0]
    for one, other in zip(answer["people"], client["room"].find_people([0]).people, strict=True):
        runs = [np.arange(first, first + count) for first, count in one["frames"][0]["runs"]]
        source = np.sort(stored.source_index[np.concatenate(runs)])
        assert np.array_equal(source, other.frames[0].numbers)


def test_recordings_without_pictures_are_refused_in_words(client: Client) -> None:
    with pytest.raises(ConflictError, match="expected frames with the colours of a depth camera"):
        client["wall"].find_people()


def test_the_missing_package_is_named(
    tmp_path: Path, sample: Sample, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    workspace = tmp_path / "workspace"
    folder = workspace / "sequences" / "room"
    import_frames(iter([sample.frame(0)]), folder, RecordingInfo("room", "room", 30.0))
    command = ["find-people", "room", "--workspace", str(workspace)]
    assert main(command) == 0
    assert "person 2\t1 frame\t" in capsys.readouterr().out
    monkeypatch.setattr(model, "RUNTIME", "no_such_package")
    model.runtime.cache_clear()
    assert main(command) != 0
    assert "pip install 'pointbrush[people]'" in capsys.readouterr().err
    model.runtime.cache_clear()


def test_the_asynchronous_client_labels_people(served: Served) -> None:
    async def searched() -> int:
        async with AsyncClient(served.url, TOKEN) as client:
            room: Recording = await client["still"]
            return (await room.label_people()).people

    assert asyncio.run(searched()) == 0


def test_a_person_before_three_cameras_is_one_person(tmp_path: Path) -> None:
    stage = Stage(SEED, 1, StageOptions())
    import_frames(stage.frames, tmp_path / "stage", RecordingInfo("stage", "Stage", 30.0))
    recording = open_sequence(FolderFiles(tmp_path / "stage"))
    frame, truth = recording[0], stage.truth[0][recording[0].source_index]
    found = Search(recording, model.PersonModel(), PeopleOptions()).people_in(0)
    assert len(found) == len(JUGGLERS)
    for person in found:
        label = np.bincount(truth[person.numbers]).argmax()
        own = np.flatnonzero(truth == label)
        assert label in JUGGLERS
        both = len(np.intersect1d(own, person.numbers))
        assert both / len(np.union1d(own, person.numbers)) > 0.85
        assert set(frame.sensor[person.numbers].tolist()) == {0, 1, 2}
