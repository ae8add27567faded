"""What leaves of a frame larger than memory: the same bytes, gathered in blocks."""

from __future__ import annotations

import io
import uuid
import zipfile
from collections.abc import Iterator
from pathlib import Path

import httpx
import laspy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pointbrush.formats import EXPORTS
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames, importer, source_order
from pointbrush.work.annotate import layers
from pointbrush.work.exporting import source_columns
from tests.serving import Served, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import viewer

POINTS = 24_000


def scan() -> PointFrame:
    """Seeded, far from the origin and in no order: exact coordinates need their residuals."""
    rng = np.random.default_rng(4)
    xyz = np.round(rng.uniform(0, 40, (POINTS, 3)), 3) + [448_000.0, 5_411_000.0, 300.0]
    return PointFrame(
        xyz,
        rng.integers(0, 256, (POINTS, 3), np.uint8),
        intensity=rng.integers(0, 4096, POINTS).astype(np.float32),
    )


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """The same frame as ``whole`` and, an octree in blocks of 5,000 points, as ``large``."""
    settings = settings_in(tmp_path_factory.mktemp("large"))
    folder = settings.workspace / "sequences"
    import_frames([scan()], folder / "whole", RecordingInfo("whole", "scan"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 8_000)
        patch.setattr(source_order, "BLOCK_POINTS", 5_000)
        patch.setattr(source_order, "PIECE_POINTS", 3_500)
        patch.setattr(layers, "READ_POINTS", 4_000)
        patch.setattr(layers, "PIECE_POINTS", 4_500)
        import_frames([scan()], folder / "large", RecordingInfo("large", "scan"))
        with serving(settings) as running:
            annotate(running)
            yield running


def annotate(served: Served) -> None:
    rng = np.random.default_rng(5)
    label = rng.integers(0, 4, POINTS).astype(np.uint16)
    deleted = rng.random(POINTS) < 0.1
    workspace = served.workspace
    for sequence in ("whole", "large"):
        for name in ("pin 1", "pin 2", "floor"):
            workspace.labels.create_label(sequence, "somebody", name=name)
        workspace.annotations.put(sequence, 0, label, author="somebody")
        workspace.annotations.put(sequence, 0, deleted, author="somebody", layer="deleted")


def get(served: Served, path: str) -> bytes:
    response = httpx.get(f"{served.url}/api/v1{path}", headers=served.headers)
    assert response.status_code == 200, response.text
    return response.content


def test_the_large_one_is_large(both: Served) -> None:
    assert both.workspace.recording("large")[0].large
    assert not both.workspace.recording("whole")[0].large
    assert len(list(source_columns(both.workspace.recording("large"), 0))) == 5


@pytest.mark.parametrize("format", ["npy", "npz"])
def test_points_have_the_same_bytes(both: Served, format: str) -> None:
    answers = [
        get(both, f"/sequences/{sequence}/frames/0/points?format={format}")
        for sequence in ("whole", "large")
    ]
    if format == "npy":
        assert answers[0] == answers[1]
    read = [np.load(io.BytesIO(answer)) for answer in answers]
    for name in ("xyz", "rgb", "intensity"):
        assert read[1][name].tobytes() == read[0][name].tobytes()
        assert read[1][name].tobytes() == getattr(scan(), name).tobytes()


@pytest.mark.parametrize("layer", ["label", "provenance", "deleted"])
def test_annotations_have_the_same_bytes(both: Served, layer: str) -> None:
    path = f"/sequences/{{}}/frames/0/annotation?layer={layer}"
    assert get(both, path.format("whole")) == get(both, path.format("large"))


# Formats of whole boxes hold no points, and masks need cameras.
@pytest.mark.parametrize(
    "format",
    sorted(name for name, entry in EXPORTS.items() if not (entry.whole_boxes or entry.pictures)),
)
def test_exports_have_the_same_files(both: Served, format: str) -> None:
    whole, large = (
        zipfile.ZipFile(io.BytesIO(get(both, f"/sequences/{sequence}/export?format={format}")))
        for sequence in ("whole", "large")
    )
    # Scenes for training are called by their recording.
    named = [name.replace("whole", "large") for name in whole.namelist()]
    assert large.namelist() == named
    for name, other in zip(whole.namelist(), named, strict=True):
        if name.endswith(".npz"):
            arrays = [np.load(io.BytesIO(archive.read(name))) for archive in (whole, large)]
            assert arrays[1].files == arrays[0].files
            for field in arrays[0].files:
                assert arrays[1][field].tobytes() == arrays[0][field].tobytes()
        elif name.endswith((".las", ".laz")):
            # laspy states the least and greatest label of each block's first point only.
            files = [laspy.read(io.BytesIO(archive.read(name))) for archive in (whole, large)]
            assert files[1].points.array.tobytes() == files[0].points.array.tobytes()
            for field in ("scales", "offsets", "mins", "maxs", "point_count"):
                assert np.array_equal(
                    getattr(files[1].header, field), getattr(files[0].header, field)
                )
        else:
            content = whole.read(name)
            if name.endswith((".json", ".txt")):
                content = content.replace(b"whole", b"large")
            assert large.read(other) == content, name


def test_a_range_that_is_not_there_is_refused_before_anything_is_sent(both: Served) -> None:
    url = f"{both.url}/api/v1/sequences/large/export?format=las&frames=4:9"
    assert httpx.get(url, headers=both.headers).status_code == 422


def test_blocks_hold_every_point_once(both: Served, tmp_path: Path) -> None:
    frame = both.workspace.recording("large")[0]
    blocks = source_order.source_blocks(
        frame, lambda first, stop: {"number": frame.read("source_index", first, stop)}
    )
    numbers = np.concatenate([block["number"] for block in blocks])
    assert np.array_equal(numbers, np.arange(POINTS))


def test_an_annotation_stays_as_it_was_while_it_is_sent(both: Served) -> None:
    workspace = both.workspace
    before, revision = workspace.annotations.read("large", 0)
    blocks, told = workspace.annotations.blocks("large", 0)
    parts = [next(blocks)]
    workspace.annotations.put("large", 0, np.zeros(POINTS, np.uint16), author="another")
    assert not workspace.annotations.read("large", 0)[0].any()
    parts += blocks
    workspace.labels.undo("large", "another")
    assert told == revision
    np.testing.assert_array_equal(np.concatenate(parts), before)
    np.testing.assert_array_equal(workspace.annotations.read("large", 0)[0], before)


def test_a_clipped_stroke_takes_the_same_points_by_rest_and_socket(both: Served) -> None:
    """Against every point tested alone: a ball over all, of which a turned box shows a part."""
    turn = Rotation.from_euler("z", 30, degrees=True)
    center, size = np.array([448_020.0, 5_411_018.0, 320.0]), np.array([18.0, 9.0, 14.0])
    clip = {
        "center": center.tolist(),
        "size": size.tolist(),
        "quaternion": turn.as_quat().tolist(),
    }
    brush = {"label": 1, "shape": "sphere", "radius": 900.0, "clip": clip}
    sample = {"origin": center.tolist()}
    off = np.abs((scan().xyz - center) @ turn.as_matrix())
    inside = (off <= size / 2).all(axis=1)
    workspace = both.workspace

    def by_rest(sequence: str) -> None:
        url = f"{both.url}/api/v1/sequences/{sequence}/frames/0/strokes"
        stroke = {**brush, "samples": [sample]}
        answer = httpx.post(url, json=stroke, headers=both.headers)
        assert answer.status_code == 200, answer.text

    def by_socket(sequence: str) -> None:
        async def scenario() -> None:
            async with viewer(both.url, both.token) as client:
                await client.open(sequence)
                stroke = str(uuid.uuid4())
                await client.send(type="stroke_begin", id=stroke, frame=0, brush=brush)
                await client.send(type="stroke_samples", id=stroke, samples=[sample])
                await client.send(type="stroke_end", id=stroke)
                await client.until("stroke_result", id=stroke, final=True)

        run(scenario)

    for sequence in ("whole", "large"):
        for way in (by_rest, by_socket):
            before = workspace.annotations.read(sequence, 0)[0]
            deleted = workspace.annotations.read(sequence, 0, layer="deleted")[0]
            expected = np.where(inside & ~deleted, np.uint16(1), before)
            way(sequence)
            np.testing.assert_array_equal(workspace.annotations.read(sequence, 0)[0], expected)
            workspace.labels.undo(sequence, workspace.labels.edits(sequence)[0].author)
            np.testing.assert_array_equal(workspace.annotations.read(sequence, 0)[0], before)


def test_frames_that_are_octrees_are_not_laid_over_one_another(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    folder = settings.workspace / "sequences" / "large"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(importer, "LARGE_POINTS", 8_000)
        import_frames([scan(), scan()], folder, RecordingInfo("large", "scan", 1.0))
    with serving(settings) as served:
        served.workspace.labels.create_label("large", "somebody", name="pin")
        frame = f"{served.url}/api/v1/sequences/large/frames/0"
        stroke = {"label": 1, "samples": [{"origin": [448_020.0, 5_411_018.0, 320.0]}]}
        answers = [
            httpx.post(f"{frame}/strokes", json={**stroke, "frames": [1]}, headers=served.headers),
            httpx.get(f"{frame}/placements?before=1&after=1", headers=served.headers),
        ]
        for answer in answers:
            assert answer.status_code == 422, answer.text
            assert "paint its frames one by one" in answer.json()["detail"]
        assert not served.workspace.annotations.read("large", 1)[0].any()

        async def scenario() -> None:
            async with viewer(served.url, served.token) as client:
                await client.open("large")
                await client.send(type="seek", frame=0, around=[1])
                told = await client.until("error")
                assert "paint its frames one by one" in told["detail"]

        run(scenario)
