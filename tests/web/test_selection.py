"""The categories that a project has selected: what labels of its recordings may be."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import BadInputError
from tests.serving import add_sequence, serving, settings_in

POINTS = 50
ROAD, CAR = 40, 10
"""Numbers of SemanticKITTI."""


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    """Recordings ``street`` and ``field`` of a project that has selected ``car``, of three."""
    settings = settings_in(tmp_path_factory.mktemp("selection"))
    for name in ("street", "field"):
        add_sequence(settings, name, frames=1, points=POINTS)
    with serving(settings) as served, Client(served.url, served.token) as client:
        names = {1: "tree", 2: "car", 3: "road"}
        entries = [{"number": number, "name": name} for number, name in names.items()]
        client.call("PUT", "/taxonomy", json={"categories": entries})
        client["street"].create_label("old oak", category="tree")
        client.projects.create("Cars", categories=[2], recordings=["street", "field"])
        yield client


def test_labels_get_categories_that_are_selected_or_in_use(client: Client) -> None:
    street, field = client["street"], client["field"]
    assert street.categories() == ["car"]
    with pytest.raises(BadInputError, match=r"has selected \(car\), got 'tree'"):
        field.create_label("oak", category="tree")
    label = field.create_label("something")
    assert field.update_label(label.id, category="car").category == "car"
    with pytest.raises(BadInputError, match="selected"):
        field.update_label(label.id, category="road")
    body = {"labels": [{"name": "lane", "category": "road"}]}
    with pytest.raises(BadInputError, match="selected"):
        client.call("POST", "/sequences/field/palette", json=body)
    assert field.add_palette("semantickitti") == ["car"]  # and no other class
    # What is in use is seen, and counts on.
    assert [each.category for each in street.labels()] == ["tree"]
    assert street.create_label("another oak", category="tree").category == "tree"


def test_labels_that_come_in_are_of_selected_categories(client: Client, tmp_path: Path) -> None:
    packed = np.where(np.arange(POINTS) % 2, CAR, ROAD).astype("<u4")
    (tmp_path / "000000.label").write_bytes(packed.tobytes())
    field = client["field"]
    report = field.import_labels(tmp_path / "000000.label", map="10 car\n40 road")
    assert "not selected are left out: road" in " ".join(report["warnings"])
    assert report["changed"] == POINTS // 2
    assert "road" not in {each.category for each in field.labels()}


def test_a_project_that_selects_all_again_has_all(client: Client) -> None:
    client.projects["cars"].change(categories=None)
    assert client["field"].categories()[:3] == ["tree", "car", "road"]
    assert client["field"].create_label("oak", category="tree").category == "tree"
