"""Classes are renamed, merged and deleted: labels and all exports follow, and no number moves."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from uuid import uuid4

import numpy as np
import pytest

from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.formats import EXPORTS
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.frame import PointFrame
from pointbrush.geometry.oriented_box import BoxPose, OrientedBox
from pointbrush.labels import Category, Label
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.teamwork.summaries import Effort, Search
from pointbrush.values.team.projects import ProjectPatch
from pointbrush.workspace import Workspace
from tests.serving import settings_in

COUNT = 240
CAR, LORRY, POST, STONE = 1, 2, 3, 4
"""Labels, of which the last one has no category."""
LABELS = (
    Label(CAR, "one", "car", "#ff0000", instance=7),
    Label(LORRY, "two", "lorry", "#00ff00", instance=7),
    Label(POST, "three", "post", "#0000ff"),
    Label(STONE, "stone", "", "#ffff00"),
)
EXPORTED = [
    *(("sqlite", kind) for kind, made in sorted(EXPORTS.items()) if not made.pictures),
    ("postgresql", "semantickitti"),
]
"""Databases and kinds of exports: the writers of files do not see the database."""
WHICH = np.repeat([CAR, LORRY, POST, STONE, 0], COUNT // 5).astype(np.uint16)


@pytest.fixture(params=["sqlite", "postgresql"])
def settings(request: pytest.FixtureRequest, tmp_path: Path) -> Settings:
    url = ""
    if request.param == "postgresql":
        url = str(request.getfixturevalue("labels_url"))
    made = settings_in(tmp_path, database=url)
    rng = np.random.default_rng(0)
    xyz = rng.uniform(-1, 1, (COUNT, 3)) + np.c_[4.0 * WHICH, np.zeros((COUNT, 2))]
    import_frames(
        (PointFrame(xyz.astype(np.float32), timestamp=1533151603.5 + k / 10) for k in range(2)),
        made.workspace / "sequences" / "drive",
        RecordingInfo("drive", "drive", 10.0),
    )
    return made


@pytest.fixture
def workspace(settings: Settings) -> Iterator[Workspace]:
    """Two frames with labels and boxes; the car came with SemanticKITTI's number."""
    with closing(Workspace(settings)) as opened:
        opened.labels.taxonomy.learn("semantickitti", {"car": 10})
        opened.labels.apply(
            "drive",
            edit_id=str(uuid4()),
            author="ann",
            kind="label",
            writes=lambda _: (LABELS, ()),
            summary="",
            boxes=[
                OrientedBox(
                    0,
                    label,
                    np.array([2.0, 2, 2]),
                    {f: BoxPose(np.array([4.0 * label, 0, 0]), np.array([0, 0, 0, 1.0]))},
                )
                for label in (CAR, LORRY)
                for f in range(2)
            ],
        )
        for frame in range(2):
            opened.annotations.put("drive", frame, WHICH, author="ann")
        yield opened


def exported(workspace: Workspace, kind: str, out: Path, snapshot: str | None = None) -> dict:
    """Contents of an export's files by name."""
    workspace.export("drive", kind, out, snapshot=snapshot)
    return {str(p.relative_to(out)): p.read_bytes() for p in out.rglob("*") if p.is_file()}


def numbers(files: dict[str, bytes]) -> dict[str, int]:
    return dict(json.loads(files["classes.json"]))


def number_of(workspace: Workspace, name: str) -> int:
    return next(e.number for e in workspace.labels.taxonomy.listed() if e.name == name)


def rename(workspace: Workspace, name: str, to: str) -> None:
    workspace.labels.taxonomy.put([Category(number_of(workspace, name), to)])


def categories(workspace: Workspace) -> dict[int, str]:
    return {label.id: label.category for label in workspace.labels.palette("drive")}


def same(one: dict[str, bytes], other: dict[str, bytes], kind: str) -> None:
    """Compare exports; of those that are packed, or have tokens of names, the names of files."""
    assert one.keys() == other.keys()
    if kind not in ("argoverse2", "npz", "nuscenes-boxes", "waymo-boxes"):
        assert one == other


@pytest.mark.parametrize(("settings", "kind"), EXPORTED, indirect=["settings"])
def test_exports_follow_new_names_merges_and_deletions(
    workspace: Workspace, tmp_path: Path, kind: str
) -> None:
    before = exported(workspace, kind, tmp_path / "before")
    _a_new_name_is_all_that_differs(workspace, tmp_path, kind, before)
    _a_merged_class_is_the_one_that_it_is_now(workspace, tmp_path, kind)
    _a_deleted_class_comes_back_with_its_number(workspace, tmp_path, kind)


def _a_new_name_is_all_that_differs(
    workspace: Workspace, folder: Path, kind: str, before: dict[str, bytes]
) -> None:
    words = {"car": "vehicle", "post": "mast"}
    for name, to in {**words, "stone": "rock"}.items():
        if name in numbers(before):
            rename(workspace, name, to)
    after = exported(workspace, kind, folder / "renamed")
    # A label without category keeps its own name, and the number of the class.
    assert numbers(after) == {words.get(w, w): number for w, number in numbers(before).items()}
    back = {
        name: data.replace(b"vehicle", b"car").replace(b"mast", b"post")
        for name, data in after.items()
    }
    same(before, back, kind)


def _a_merged_class_is_the_one_that_it_is_now(
    workspace: Workspace, folder: Path, kind: str
) -> None:
    store = workspace.labels
    store.update_label("drive", "ann", POST, category="vehicle")
    by_hand = exported(workspace, kind, folder / "by hand")
    store.undo("drive", "ann")
    store.taxonomy.merge(number_of(workspace, "vehicle"), [number_of(workspace, "mast")])
    merged = exported(workspace, kind, folder / "merged")
    same(by_hand, merged, kind)
    assert categories(workspace) == {CAR: "vehicle", LORRY: "lorry", POST: "vehicle", STONE: ""}


def _a_deleted_class_comes_back_with_its_number(
    workspace: Workspace, folder: Path, kind: str
) -> None:
    store, lorry = workspace.labels, number_of(workspace, "lorry")
    with pytest.raises(ConflictError, match=r"'lorry' has 1 labels \(recordings: drive\)"):
        store.taxonomy.remove(lorry)
    before = exported(workspace, kind, folder / "there")
    store.update_label("drive", "ann", LORRY, category="vehicle")
    store.taxonomy.remove(lorry)
    assert "lorry" not in [entry.name for entry in store.taxonomy.listed()]
    after = exported(workspace, kind, folder / "gone")
    assert numbers(after).items() <= numbers(before).items()
    store.undo("drive", "ann")
    same(before, exported(workspace, kind, folder / "again"), kind)
    assert number_of(workspace, "lorry") == lorry


def test_labels_of_merged_classes_stay_apart(workspace: Workspace, tmp_path: Path) -> None:
    workspace.labels.taxonomy.merge(number_of(workspace, "car"), [number_of(workspace, "lorry")])
    files = exported(workspace, "semantickitti", tmp_path / "out")
    packed = np.frombuffer(files["sequences/00/labels/000000.label"], "<u4")
    found = [set(packed[label == WHICH].tolist()) for label in (CAR, LORRY)]
    assert [len(each) for each in found] == [1, 1]
    assert found[0] != found[1]
    assert {number & 0xFFFF for each in found for number in each} == {10}


def test_undo_and_redo_of_what_was_done_before_bring_no_old_name_back(
    workspace: Workspace,
) -> None:
    store = workspace.labels
    lorry = number_of(workspace, "lorry")
    store.update_label("drive", "ann", POST, category="car")
    store.update_label("drive", "ann", CAR, color="#123456")
    store.delete_label("drive", "ann", LORRY)
    rename(workspace, "car", "vehicle")
    rename(workspace, "post", "mast")
    store.taxonomy.merge(number_of(workspace, "mast"), [lorry])
    assert categories(workspace) == {CAR: "vehicle", POST: "vehicle", STONE: ""}
    for _ in range(3):
        store.undo("drive", "ann")
    assert categories(workspace) == {CAR: "vehicle", LORRY: "mast", POST: "mast", STONE: ""}
    for _ in range(3):
        store.redo("drive", "ann")
    assert categories(workspace) == {CAR: "vehicle", POST: "vehicle", STONE: ""}
    assert workspace.listing.problems("drive") == []


def test_another_server_has_the_new_name_at_once(settings: Settings, workspace: Workspace) -> None:
    with closing(Workspace(settings)) as other:
        assert categories(other)[CAR] == "car"
        rename(workspace, "car", "vehicle")
        assert categories(other)[CAR] == "vehicle"
        # The old name is free there, too, and is another class.
        made = other.labels.create_label("drive", "ben", name="new", category="car")
        assert made.category == "car"
        assert categories(workspace) | {made.id: "car"} == categories(workspace)
    numbers = workspace.labels.taxonomy.numbers(["car", "vehicle"])
    assert len(set(numbers.values())) == 2
    rename(workspace, "car", "auto")
    assert (categories(workspace)[CAR], categories(workspace)[made.id]) == ("vehicle", "auto")


def test_names_that_change_places_take_their_labels_with_them(workspace: Workspace) -> None:
    car, lorry = number_of(workspace, "car"), number_of(workspace, "lorry")
    workspace.labels.taxonomy.put([Category(car, "lorry"), Category(lorry, "car")])
    assert categories(workspace) == {CAR: "lorry", LORRY: "car", POST: "post", STONE: ""}
    # A class may take the name of one that was deleted, and not that of another one.
    workspace.labels.taxonomy.put([Category(900, "tram")])
    workspace.labels.taxonomy.remove(900)
    with pytest.raises(ConflictError, match="'tram' to keep its number 900, got 901"):
        workspace.labels.taxonomy.put([Category(901, "tram")])
    rename(workspace, "post", "tram")
    assert categories(workspace)[POST] == "tram"
    workspace.labels.update_label("drive", "ann", POST, category="bus")
    with pytest.raises(ConflictError, match="labels of no other category have, got 'bus'"):
        workspace.labels.taxonomy.put([Category(car, "bus")])


def test_what_cannot_be_merged_is_refused(workspace: Workspace) -> None:
    car = number_of(workspace, "car")
    for others in ([], [car], [99, 99]):
        with pytest.raises(BadInputError):
            workspace.labels.taxonomy.merge(car, others)
    for number, others in ((car, [999]), (999, [car])):
        with pytest.raises(NotFoundError):
            workspace.labels.taxonomy.merge(number, others)
    post = number_of(workspace, "post")
    workspace.labels.taxonomy.merge(car, [post])
    with pytest.raises(ConflictError, match=f"{post} was merged into {car}"):
        workspace.labels.taxonomy.put([Category(post, "post")])
    with pytest.raises(NotFoundError):
        workspace.labels.taxonomy.remove(post)


def test_versions_projects_and_searches_follow(workspace: Workspace, tmp_path: Path) -> None:
    store, car = workspace.labels, number_of(workspace, "car")
    selected = ProjectPatch("Streets", categories=[car], recordings=["drive"])
    store.team.projects.create("streets", selected)
    version = workspace.versions.create("streets", "First", "ann").id
    before = exported(workspace, "semantickitti", tmp_path / "before", version)
    rename(workspace, "car", "vehicle")
    after = exported(workspace, "semantickitti", tmp_path / "after", version)
    assert [
        name for name in before if name.endswith(".label") and before[name] != after[name]
    ] == []
    assert store.team.projects.selection("drive") == {"vehicle"}
    found = {
        name: store.team.summaries.matching(Search(category=name)) for name in ("car", "Vehicle")
    }
    assert (list(found["car"]), list(found["Vehicle"])) == ([], ["drive"])
    effort = Effort(60.0, 1.0, (), ())
    names = [each.name for each in store.team.summaries.figures("streets", effort).classes]
    assert sorted(names) == ["lorry", "post", "stone", "vehicle"]
    with pytest.raises(BadInputError, match="selected"):
        store.create_label("drive", "ann", name="new", category="tram")
    assert store.create_label("drive", "ann", name="new", category="vehicle").category == "vehicle"


def test_a_class_that_came_with_an_official_number_leaves_with_it(
    workspace: Workspace, tmp_path: Path
) -> None:
    """Also where another class has its name or its number by now, or had them first."""
    taxonomy = workspace.labels.taxonomy
    taxonomy.learn("semantickitti", {"asphalt": 40}, strict=False)  # of files that number otherwise
    taxonomy.numbers(["fence"])
    taxonomy.learn("semantickitti", {"road": 40, "fence": 51}, strict=False)
    datasets = {entry.name: entry.datasets for entry in taxonomy.entries()}
    assert (datasets["road"], datasets["fence"]) == ({"semantickitti": 40}, {"semantickitti": 51})
    assert datasets["asphalt"] == {}
    taxonomy.put([Category(500, "Baum", datasets={"semantickitti": 70})])
    taxonomy.learn("semantickitti", {"vegetation": 70}, strict=False)  # a person has the last word
    rename(workspace, "fence", "hedge")
    assert taxonomy.known_classes("semantickitti", {51: "fence", 70: "vegetation", 40: "tar"}) == {
        51: "hedge",
        70: "Baum",
    }


def test_own_classes_get_official_numbers_by_their_names_alone(
    workspace: Workspace, tmp_path: Path
) -> None:
    words = ("traffic sign", "truck", "ground", "scooter")
    for word in words:
        workspace.labels.create_label("drive", "ann", name=f"a {word}", category=word)
    found = {
        kind: numbers(exported(workspace, kind, tmp_path / kind))
        for kind in ("semantickitti", "las")
    }
    official = {"traffic sign": 81, "truck": 18}
    assert official.items() <= found["semantickitti"].items()
    assert found["las"]["ground"] == 2
    others = {found["semantickitti"][word] for word in ("post", "scooter", "ground")}
    assert not SEMANTIC_KITTI.classes.keys() & others
    assert min(number for word, number in found["las"].items() if word != "ground") >= 64


def test_a_recording_of_a_backup_has_the_classes_of_where_it_comes_to(
    settings: Settings, workspace: Workspace, tmp_path: Path
) -> None:
    workspace.back_up(tmp_path / "before")
    rename(workspace, "car", "vehicle")
    workspace.back_up(tmp_path / "after")
    copy = workspace.restore_from_backup(tmp_path / "before", "drive")
    assert {e.category for e in workspace.labels.palette(copy)} == {"vehicle", "lorry", "post", ""}
    with closing(Workspace(settings_in(tmp_path / "elsewhere"))) as other:
        other.labels.taxonomy.put([Category(1, "road"), Category(2, "lorry", "#111111")])
        copy = other.restore_from_backup(tmp_path / "after", "drive")
        other.labels.undo(copy, "ann")
        names = {label.category for label in other.labels.palette(copy)}
        assert names == {"vehicle", "lorry", "post", ""}
        other.export(copy, "semantickitti", tmp_path / "out")
        told = json.loads((tmp_path / "out" / "classes.json").read_text())
        assert told["vehicle"] == 10
