"""Large frames: the octree holds each point once, in bounded pieces, and loses nothing."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pointbrush.errors import BadInputError, CancelledError, DamagedError, TooLargeError
from pointbrush.frame import PointFrame, Scaling
from pointbrush.sequences import (
    Manifest,
    RecordingInfo,
    StoredFrame,
    import_frames,
    import_large,
    importer,
    open_sequence,
    verify,
)
from pointbrush.sequences.columns import residual
from pointbrush.sequences.octree import nodes as octree
from pointbrush.sequences.octree import partition
from pointbrush.sequences.octree.nodes import build, hand_up, sort_codes
from pointbrush.sequences.octree.order import morton_codes
from tests.sequences.vertex_decoder import decode_points, dequantise


@pytest.fixture
def small_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same machinery at a hundredth of the size."""
    monkeypatch.setattr(importer, "LARGE_POINTS", 20_000)
    monkeypatch.setattr(importer, "_PART_POINTS", 7_000)
    monkeypatch.setattr(partition, "CELL_ROWS", 8_000)
    monkeypatch.setattr(partition, "MAX_CELLS", 40)
    monkeypatch.setattr(octree, "NODE_POINTS", 1000)
    monkeypatch.setattr(octree, "_KEPT", 500)
    monkeypatch.setattr(octree, "_FEW", 120)
    monkeypatch.setattr(octree, "_WHOLLY_UP", 60)
    monkeypatch.setattr(octree, "_HANDED_UP", 125)


def site(count: int, seed: int = 0, far: float = 0.0, dtype: type = np.float64) -> PointFrame:
    """A terrain with a dense scan of one corner, in random order."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0, 200, (count, 2))
    dense = rng.random(count) < 0.5
    xy[dense] = rng.normal(20, 1.5, (int(dense.sum()), 2))
    z = 5 * np.sin(xy[:, 0] / 30) + rng.normal(0, 0.02, count)
    return PointFrame(
        (np.column_stack([xy, z]) + far).astype(dtype),
        rgb=rng.integers(0, 256, (count, 3)).astype(np.uint8),
        intensity=rng.uniform(0, 60_000, count).astype(np.float32),
        label=rng.integers(0, 5, count).astype(np.uint16),
    )


def put(parts: Iterator[PointFrame] | list[PointFrame], target: Path) -> Manifest:
    return import_large(parts, target, RecordingInfo("s", "Scan"))


def assert_octree(stored: StoredFrame, manifest: Manifest, node_points: int) -> None:
    table = stored.chunk_table
    assert table["first"].tolist() == [0, *np.cumsum(table["count"])[:-1].tolist()]
    assert int(table["count"].sum()) == stored.count
    assert table["offset"].tolist() == [0, *np.cumsum(table["nbytes"])[:-1].tolist()]
    assert table["count"].min() > 0
    assert table["count"].max() <= node_points
    assert table["parent"][0] == -1
    assert table["level"][0] == table["level"].min()
    above = table["parent"][1:]
    assert ((above >= 0) & (above < np.arange(1, len(table)))).all()
    assert (table["level"][1:] > table["level"][above]).all()
    numbers = np.sort(stored.source_index)
    assert np.array_equal(numbers, np.arange(stored.count))
    for chunk in stored.chunks:
        vertices = decode_points(stored.wire(chunk.index, chunk.index + 1), chunk.count)
        q = np.ascontiguousarray(vertices[:, :6]).view(np.uint16)
        back = dequantise(q, np.array(chunk.origin), np.array(chunk.scale))
        points = stored.xyz[chunk.first : chunk.first + chunk.count]
        assert np.abs(back.astype(float) - points).max() <= manifest.position_error
        assert np.array_equal(points.min(axis=0), chunk.lo)
        assert np.array_equal(points.max(axis=0), chunk.hi)


@pytest.mark.parametrize(("far", "dtype"), [(0.0, np.float32), (0.0, float), (4.2e6, float)])
def test_every_point_once_and_exact(
    tmp_path: Path, small_limits: None, far: float, dtype: type
) -> None:
    whole = site(60_000, far=far, dtype=dtype)
    said: list[float] = []
    manifest = import_large(
        importer.split(whole),
        tmp_path / "s",
        RecordingInfo("s", "Scan"),
        total_points=60_000,
        progress=lambda fraction, _: said.append(fraction),
    )
    assert manifest.large
    assert manifest.points == [60_000]
    assert manifest.fields == ["xyz", "rgb", "intensity", "label"]
    assert said == sorted(said)
    assert said[-1] == 1.0
    assert verify(tmp_path / "s") == []
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.source_xyz().tobytes() == whole.xyz.tobytes()
    for name in ("rgb", "intensity", "label"):
        assert np.array_equal(stored.to_source(getattr(stored, name)), getattr(whole, name))
    assert_octree(stored, manifest, 1000)
    assert stored.chunk_table["level"].max() > 4
    with pytest.raises(TooLargeError, match="k-d tree"):
        _ = stored.kdtree


@pytest.mark.parametrize(("far", "dtype"), [(0.0, np.float32), (4.2e6, float)])
def test_octrees_of_before_manifest_version_4_are_read(
    tmp_path: Path, small_limits: None, far: float, dtype: type
) -> None:
    whole = site(30_000, far=far, dtype=dtype)
    manifest = put(importer.split(whole), tmp_path / "s")
    packed = open_sequence(tmp_path / "s")[0]
    place, shift = tmp_path / "s" / "frames" / "000000", np.array(manifest.shift)
    exact = residual(whole.xyz[packed.source_index], packed.xyz, shift)
    np.save(place / "xyz.npy", packed.xyz)
    if exact is not None:
        np.save(place / "residual.npy", exact)
    for name in ("coordinates", "block_base", "block_bits"):
        (place / f"{name}.npy").unlink()
    (place / "meta.json").write_text(json.dumps({"dtype": whole.xyz.dtype.name}))
    (tmp_path / "s" / "checksums.json").unlink()
    plain = open_sequence(tmp_path / "s")[0]
    assert plain.source_xyz().tobytes() == whole.xyz.tobytes()
    some = np.array([5, 29_000, 17])
    assert np.array_equal(plain.coordinates[some], packed.coordinates[some])
    assert_octree(plain, manifest, 1000)


@pytest.mark.parametrize("source", ["LAS", "text", "decimals in float32", "any float32"])
def test_an_octree_takes_at_most_22_bytes_a_point_and_is_exact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    monkeypatch.setattr(importer, "LARGE_POINTS", 100_000)
    count, rng, scaling = 150_000, np.random.default_rng(3), None
    whole = site(count).xyz
    if source == "LAS":
        scaling = Scaling(np.full(3, 0.001), np.array([448_000.0, 5_411_000.0, 0.0]))
        whole = np.rint((whole + [260, 930, 310]) * 1000) * scaling.scale + scaling.offset
    elif source != "any float32":
        whole = np.rint(whole * 1000) / 1000
    if "float32" in source:
        whole = whole.astype(np.float32)
    # A point that is no whole number of millimetres, and the zero with a sign.
    whole[7, 0], whole[9, 2] = np.nextafter(whole[7, 0], whole.dtype.type(1e9)), -0.0
    rgb = (128 + 70 * np.sin(whole * 0.7)).astype(np.uint8) + rng.integers(0, 8, (count, 3), "u1")
    frame = PointFrame(whole, rgb=rgb, scaling=scaling)
    put(importer.split(frame), tmp_path / "s")
    used = sum(path.stat().st_size for path in (tmp_path / "s").rglob("*") if path.is_file())
    assert used <= 22 * count
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.source_xyz().tobytes() == whole.tobytes()
    picked = np.sort(rng.choice(count, 1000, replace=False))
    assert np.array_equal(stored.coordinates[picked], stored.xyz[picked])
    assert np.array_equal(stored.coordinates[:500], stored.xyz[:500])
    exact = stored.read_source(1000, 3000, ["xyz"])["xyz"]
    assert exact.tobytes() == whole[stored.source_index[1000:3000]].tobytes()
    with pytest.raises(IndexError, match=f"points 0 to {count - 1}"):
        stored.coordinates[np.array([count])]


def test_upper_levels_are_an_even_picture(tmp_path: Path, small_limits: None) -> None:
    manifest = put(importer.split(site(60_000)), tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    top = stored.xyz[: stored.chunks[0].count, :2]
    # Half of the points lie in the dense corner, but hardly any of the first picture's.
    dense = float((np.abs(top + np.array(manifest.shift[:2]) - 20) < 4).all(axis=1).mean())
    assert dense < 0.1
    tiles = np.unique((top // 20).astype(int), axis=0)
    assert len(tiles) >= 95


def test_blocks_of_an_octree_find_a_ball(tmp_path: Path, small_limits: None) -> None:
    put(importer.split(site(60_000)), tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    centre = np.array([20.0, 20.0, 3.0])
    found = stored.blocks.overlapping(centre - 1, centre + 1)
    points = np.concatenate([np.arange(*stored.blocks.first[b : b + 2]) for b in found])
    inside = np.flatnonzero((np.abs(stored.xyz - centre) <= 1).all(axis=1))
    assert len(inside) > 500
    assert np.isin(inside, points).all()
    assert np.diff(stored.blocks.first).max() <= 256


@pytest.mark.parametrize("kind", ["one place", "two clusters", "a line", "growing strip"])
def test_awkward_shapes(tmp_path: Path, small_limits: None, kind: str) -> None:
    rng = np.random.default_rng(0)
    xyz = np.full((30_000, 3), 7.25)
    if kind == "two clusters":
        xyz = rng.normal(0, 1e-3, (30_000, 3))
        xyz[::2] += 900
    if kind == "a line":
        xyz[:, 0] = rng.uniform(-300, 300, 30_000)
    if kind == "growing strip":
        # The first part says nothing of how far the others reach.
        xyz[:, 0] = np.sort(rng.uniform(0, 1, 30_000) ** 4 * 900)
        xyz[:, 1] = rng.uniform(-1, 1, 30_000)
    manifest = put(importer.split(PointFrame(xyz)), tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    assert manifest.large
    assert stored.source_xyz().tobytes() == xyz.tobytes()
    table = stored.chunk_table
    assert int(table["count"].sum()) == 30_000
    assert table["count"].max() <= 1000
    assert np.array_equal(np.sort(stored.source_index), np.arange(30_000))


def test_a_frame_that_fits_is_stored_as_usual(tmp_path: Path, small_limits: None) -> None:
    whole = site(15_000)
    manifest = put(importer.split(whole), tmp_path / "s")
    assert not manifest.large
    assert open_sequence(tmp_path / "s")[0].source_xyz().tobytes() == whole.xyz.tobytes()
    assert open_sequence(tmp_path / "s")[0].kdtree.n == 15_000


def test_a_sequence_may_hold_large_frames(tmp_path: Path, small_limits: None) -> None:
    frames = [site(30_000, 1), site(500, 2), site(25_000, 3)]
    manifest = import_frames(frames, tmp_path / "s", RecordingInfo("s", "n", 1))
    assert manifest.large
    sequence = open_sequence(tmp_path / "s")
    assert [sequence[i].large for i in range(3)] == [True, False, True]
    for index, frame in enumerate(frames):
        assert sequence[index].source_xyz().tobytes() == frame.xyz.tobytes()
    assert verify(tmp_path / "s") == []


def test_failures_leave_nothing(tmp_path: Path, small_limits: None) -> None:
    def broken() -> Iterator[PointFrame]:
        yield from importer.split(site(40_000))
        raise BadInputError("point 40000: expected 26 bytes, got 3")

    with pytest.raises(BadInputError, match="point 40000"):
        put(broken(), tmp_path / "s")
    bare = PointFrame(np.zeros((10, 3)))
    with pytest.raises(BadInputError, match="every part"):
        put([*importer.split(site(30_000)), bare], tmp_path / "s")
    with pytest.raises(BadInputError, match="at least one frame"):
        put([], tmp_path / "s")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("message", ["read", "ordered", "writing", "checksums"])
def test_cancelling_at_any_stage_leaves_nothing(
    tmp_path: Path, small_limits: None, message: str
) -> None:
    def cancel(_: float, said: str) -> None:
        if said.startswith(message):
            raise CancelledError("cancelled by its user")

    with pytest.raises(CancelledError):
        import_large(
            importer.split(site(30_000)), tmp_path / "s", RecordingInfo("s", "n"), progress=cancel
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["coordinates.npy", "chunks.npy", "meta.json"])
def test_damage_is_found_and_refused(tmp_path: Path, small_limits: None, name: str) -> None:
    put(importer.split(site(30_000)), tmp_path / "s")
    file = tmp_path / "s" / "frames" / "000000" / name
    file.write_bytes(b"\x00" + file.read_bytes()[1:])
    assert [problem for problem in verify(tmp_path / "s") if name in problem]
    with pytest.raises(DamagedError, match="frame 0 is damaged: expected stored arrays"):
        open_sequence(tmp_path / "s")[0]


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 150_000), st.floats(0.1, 6))
def test_nodes_share_out_all_points(seed: int, count: int, power: float) -> None:
    rng = np.random.default_rng(seed)
    xyz = (rng.random((count, 3)) ** power).astype(np.float32)
    codes, order = sort_codes(morton_codes(xyz, np.zeros(3), 1.0))
    assert np.array_equal(np.sort(order), np.arange(count))
    up = hand_up(codes)
    assert len(np.unique(up)) == len(up) <= max(2048, 8192)
    rest = np.setdiff1d(np.arange(count), up)
    nodes = build(codes, rest)
    kept = np.concatenate([np.empty(0, int), *(node.positions for node in nodes)])
    assert np.array_equal(np.sort(kept), rest)
    for number, node in enumerate(nodes):
        assert 0 < len(node.positions) <= 65536
        assert node.parent < number
        assert (np.diff(node.positions) > 0).all()
