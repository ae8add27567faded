"""Pictures of cameras come in with a recording, and go out as they came with their projection."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import NotFoundError
from pointbrush.sequences import verify
from tests.formats.test_pictures import AHEAD, K, described, jpeg
from tests.serving import TOKEN, Served, serving, settings_in


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    (tmp_path / "inbox").mkdir()
    with serving(settings_in(tmp_path, import_roots=str(tmp_path / "inbox"))) as running:
        yield running


def test_pictures_and_projections_come_back_as_they_were(served: Served, tmp_path: Path) -> None:
    folder = described(tmp_path / "inbox" / "room")
    asked = {"path": str(folder)}
    url = f"{served.url}/api/v1"
    preview = httpx.post(f"{url}/imports/preview", json=asked, headers=served.headers).json()
    assert preview["cameras"] == [{"name": "front", "projects": True}]
    with Client(served.url, TOKEN) as client:
        room = client.import_path(str(folder))
        (camera,) = room.frames[0].cameras()
        assert (camera.name, camera.width, camera.height) == ("front", 64, 48)
        assert np.array_equal(camera.K, K)
        assert np.array_equal(camera.T_camera_frame, AHEAD)
        assert camera.distortion == (0.1, -0.2, 0, 0, 0.05)
        assert room.frames[0].image("front") == jpeg(0)
        assert room.frames[1].cameras() == []
        with pytest.raises(NotFoundError, match="expected one of frame 1"):
            room.frames[1].image("front")
        with pytest.raises(NotFoundError):
            room.frames[2].image("../000000.json")
    place = f"{url}/sequences/{room.id}/frames/2/images/front"
    answer = httpx.get(place, headers=served.headers)
    assert answer.headers["content-type"] == "image/jpeg"
    known = served.headers | {"If-None-Match": answer.headers["etag"]}
    assert httpx.get(place, headers=known).status_code == 304
    assert httpx.get(place).status_code == 401
    assert verify(served.workspace.recording(room.id).path) == []
