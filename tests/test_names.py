"""Names of recordings, labels and classes hold no control or bidirectional characters."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.class_maps import ClassNumbers, parse_map
from pointbrush.labels import Category
from pointbrush.names import require_visible, spelled_out
from tests.serving import Served, add_sequence, serving, settings_in
from tests.waiting import eventually

HIDDEN = ["\u202e", "\u2066", "\x07", "\x85", "\u2028"]
VISIBLE = ["Fußgänger 1", "رجل", "人 (left)", "a\u200db"]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("names")
    settings = settings_in(folder, import_roots=str(folder))
    add_sequence(settings, "wall", frames=3, points=1_000)
    with serving(settings) as running:
        yield running


def test_what_is_hidden_is_refused_and_spelled_out() -> None:
    for sign in HIDDEN:
        with pytest.raises(BadInputError, match=r"got 'a.*b'"):
            require_visible("name", f"a{sign}b")
        assert spelled_out(f"a{sign}b") == f"a{sign.encode('unicode_escape').decode()}b"
    for name in VISIBLE:
        require_visible("name", name)
        assert spelled_out(name) == name


CALLS: list[tuple[str, str, dict[str, Any]]] = [
    ("PATCH", "/sequences/wall", {"name": "{}"}),
    ("POST", "/sequences/wall/labels", {"name": "{}"}),
    ("POST", "/sequences/wall/labels", {"name": "pin", "category": "{}"}),
    ("PATCH", "/sequences/wall/labels/1", {"name": "{}"}),
    ("PATCH", "/sequences/wall/labels/1", {"category": "{}"}),
    ("POST", "/sequences/wall/palette", {"labels": [{"name": "{}"}]}),
    ("PUT", "/taxonomy", {"categories": [{"number": 7, "name": "{}"}]}),
    ("POST", "/sequences", {"path": "/nothing", "name": "{}"}),
]


@pytest.mark.parametrize(("method", "path", "body"), CALLS)
def test_rest_refuses_them_and_changes_nothing(
    api: httpx.Client, method: str, path: str, body: dict[str, Any]
) -> None:
    before = [api.get(one).text for one in ("/sequences", "/sequences/wall/labels", "/taxonomy")]
    for sign in HIDDEN:
        content = json.dumps(body).replace("{}", json.dumps(f"exe{sign}gnp")[1:-1])
        answer = api.request(method, path, content=content)
        assert answer.status_code in (400, 422), answer.text
    after = [api.get(one).text for one in ("/sequences", "/sequences/wall/labels", "/taxonomy")]
    assert after == before


def test_the_workspace_refuses_them_too(served: Served) -> None:
    bad = "exe\u202egnp"
    workspace = served.workspace
    with pytest.raises(BadInputError, match="bidirectional"):
        workspace.update_sequence("wall", name=bad)
    for fields in ({"name": bad}, {"name": "pin", "category": bad}):
        with pytest.raises(BadInputError, match="bidirectional"):
            workspace.labels.create_label("wall", "ann", **fields)
    with pytest.raises(BadInputError, match="bidirectional"):
        workspace.labels.taxonomy.put([Category(9, bad)])


def test_class_names_in_files_are_written_out() -> None:
    numbers = ClassNumbers()
    assert numbers.number("a.csv", "car\u202e") == 1
    assert numbers.number("a.csv", "car\u202d") == 2
    assert numbers.names == [r"car\u202e", r"car\u202d"]
    assert parse_map("map.json", '{"1": "car\\u202e"}')[1].name == r"car\u202e"


def test_a_file_with_such_names_comes_in_with_them_written_out(
    api: httpx.Client, served: Served, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = served.workspace.settings.workspace.parent / "exe\u202egnp"
    folder.mkdir()
    points = np.random.default_rng(1).uniform(0, 1, (50, 3))
    lines = ["x,y,z,label", *(f"{x},{y},{z},car\u202e" for x, y, z in points)]
    (folder / "0.csv").write_text("\n".join(lines), encoding="utf-8")
    job = api.post("/sequences", json={"path": str(folder)}).json()
    ended = eventually(
        lambda: (
            (told := api.get(f"/jobs/{job['id']}").json())["state"] in ("done", "failed") and told
        ),
        60,
    )
    assert ended["state"] == "done", ended
    sequence = ended["sequence"]
    assert api.get(f"/sequences/{sequence}").json()["name"] == r"exe\u202egnp"
    assert [each["name"] for each in api.get(f"/sequences/{sequence}/labels").json()] == [
        r"car\u202e"
    ]


def test_one_recording_tells_its_labelled_frames_as_the_list_does(
    api: httpx.Client, served: Served
) -> None:
    label = served.workspace.labels.create_label("wall", "ann", name="counted").id
    for frame in (0, 2):
        values = np.full(served.workspace.recording("wall").manifest.points[frame], label)
        served.workspace.annotations.put("wall", frame, values.astype(np.uint16), author="ann")
    [listed] = [one for one in api.get("/sequences").json() if one["id"] == "wall"]
    assert listed["labelled"] == 2
    assert api.get("/sequences/wall").json() == listed
