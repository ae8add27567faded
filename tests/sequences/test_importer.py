"""Import and open: nothing lost, nothing half-written."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pointbrush.errors import (
    BadInputError,
    ConflictError,
    DamagedError,
    NotFoundError,
    UnavailableError,
)
from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.samples import generate
from pointbrush.sequences import (
    Manifest,
    RecordingInfo,
    clean_temporary,
    import_frames,
    open_sequence,
    read_manifest,
    update_manifest,
    verify,
)
from pointbrush.sequences import importer as importer_module
from pointbrush.sequences.storage.manifest import VERSION
from tests import forked
from tests.sequences.vertex_decoder import decode_points, dequantise
from tests.waiting import eventually


def frame(count: int, seed: int = 0, far: float = 0.0, dtype: type = np.float32) -> PointFrame:
    rng = np.random.default_rng(seed)
    xyz = (rng.uniform(-2, 2, (count, 3)) + far).astype(dtype)
    return PointFrame(
        xyz,
        # Alike in all three, as light is: the wire keeps them as they are.
        rgb=(rng.integers(0, 240, (count, 1)) + rng.integers(0, 16, 3)).astype(np.uint8),
        intensity=rng.uniform(0, 255, count).astype(np.float32),
        label=rng.integers(0, 9, count).astype(np.uint16),
        instance=rng.integers(0, 9, count).astype(np.uint16),
        pose=np.eye(4),
        viewpoint=np.array([0.0, 1.0, 2.0]) + far,
        timestamp=seed / 30,
        dropped=seed,
    )


def put(frames: list[PointFrame] | Iterator[PointFrame], target: Path) -> Manifest:
    return import_frames(frames, target, RecordingInfo("s", "A recording", 30.0))


def test_everything_comes_back_in_source_order(tmp_path: Path) -> None:
    frames = [frame(5000, seed) for seed in range(7)]
    said: list[tuple[float, str]] = []
    manifest = import_frames(
        iter(frames),
        tmp_path / "s",
        RecordingInfo("s", "A recording", 30.0, source="there"),
        total=7,
        progress=lambda fraction, message: said.append((fraction, message)),
    )
    sequence = open_sequence(tmp_path / "s")
    assert sequence.manifest == manifest
    assert len(sequence) == manifest.frames == 7
    assert manifest.points == [5000] * 7
    assert manifest.fields == ["xyz", "rgb", "intensity", "label", "instance"]
    assert manifest.dropped == list(range(7))
    assert (manifest.source, manifest.large) == ("there", False)
    assert [fraction for fraction, _ in said] == pytest.approx([i / 7 for i in range(1, 8)])
    for given_frame, stored in zip(frames, sequence, strict=True):
        assert stored.source_xyz().tobytes() == given_frame.xyz.tobytes()
        for name in ("rgb", "intensity", "label", "instance"):
            values = getattr(stored, name)
            assert np.array_equal(stored.to_source(values), getattr(given_frame, name))
            assert np.array_equal(getattr(given_frame, name)[stored.source_index], values)
        assert stored.timestamp == given_frame.timestamp
        assert np.array_equal(stored.viewpoint, given_frame.viewpoint)
        assert np.array_equal(stored.pose, np.eye(4))
    assert verify(tmp_path / "s") == []


def test_values_of_another_number_of_points_are_refused(tmp_path: Path) -> None:
    put([frame(3000)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    with pytest.raises(BadInputError, match="expected 3000 values, got 5"):
        stored.to_source(np.zeros(5))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("far", [0.0, -900.0, 123_456.789, 4_500_000.0])
def test_coordinates_are_exact_however_far(tmp_path: Path, dtype: type, far: float) -> None:
    given_frame = frame(2000, far=far, dtype=dtype)
    manifest = put([given_frame], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.source_xyz().dtype == dtype
    assert stored.source_xyz().tobytes() == given_frame.xyz.tobytes()
    assert np.abs(stored.xyz).max() < 1024
    assert (np.array(manifest.shift) != 0).any() == (abs(far) > 1024)
    local = given_frame.xyz.astype(np.float64) - manifest.shift
    assert np.abs(stored.to_source(stored.xyz) - local).max() < 1e-4


@given(
    arrays(
        np.float64,
        st.tuples(st.integers(0, 30), st.just(3)),
        elements=st.floats(-1e30, 1e30) | st.sampled_from([0.0, -0.0, 1e-310, 4_503_599.25]),
    )
)
def test_any_coordinates_come_back_bit_for_bit(xyz: np.ndarray) -> None:
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        manifest = put([PointFrame(xyz)], Path(folder) / "s")
        stored = open_sequence(Path(folder) / "s")[0]
        assert stored.source_xyz().tobytes() == xyz.tobytes()
        assert_wire(stored, manifest)


def assert_wire(stored, manifest) -> None:  # type: ignore[no-untyped-def]
    """Decoded chunks are the stored points, in order, within the manifest's error."""
    at, offset = 0, 0
    for number, chunk in enumerate(stored.chunks):
        assert (chunk.index, chunk.first, chunk.offset, chunk.parent) == (number, at, offset, -1)
        assert 0 < chunk.count <= 65536
        data = stored.wire(number, number + 1)
        assert len(data) == chunk.nbytes
        vertices = decode_points(data, chunk.count)
        q = np.ascontiguousarray(vertices[:, :6]).view(np.uint16)
        back = dequantise(q, np.array(chunk.origin), np.array(chunk.scale))
        points = stored.xyz[at : at + chunk.count]
        difference = np.abs(back.astype(np.float64) - points)
        assert difference.max() <= manifest.position_error
        assert np.array_equal(points.min(axis=0), chunk.lo)
        assert np.array_equal(points.max(axis=0), chunk.hi)
        if stored.rgb is not None:
            assert np.array_equal(vertices[:, 6:9], stored.rgb[at : at + chunk.count])
        at += chunk.count
        offset += chunk.nbytes
    assert at == stored.count
    assert len(stored.wire(0, len(stored.chunks))) == offset


def test_the_wire_holds_all_points_progressively(tmp_path: Path) -> None:
    manifest = put([frame(200_000)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    assert_wire(stored, manifest)
    levels = [chunk.level for chunk in stored.chunks]
    assert levels == sorted(levels)
    assert 2000 <= stored.chunks[0].count <= 4096
    with pytest.raises(NotFoundError, match="chunks within"):
        stored.wire(0, len(levels) + 1)


def test_blocks_bound_their_points_and_find_them(tmp_path: Path) -> None:
    put([frame(30_000)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    blocks = stored.blocks
    assert blocks.first[0] == 0
    assert blocks.first[-1] == 30_000
    assert np.diff(blocks.first).min() > 0
    assert np.diff(blocks.first).max() <= 256
    centre = np.array([0.3, -0.2, 1.0])
    found = blocks.overlapping(centre - 0.2, centre + 0.2)
    assert len(found) < len(blocks.lo) / 4
    points = np.concatenate([np.arange(*blocks.first[b : b + 2]) for b in found])
    inside = np.flatnonzero((np.abs(stored.xyz - centre) <= 0.2).all(axis=1))
    assert np.isin(inside, points).all()
    for b in range(len(blocks.lo)):
        run = stored.xyz[blocks.first[b] : blocks.first[b + 1]]
        assert np.array_equal(run.min(axis=0), blocks.lo[b])
        assert np.array_equal(run.max(axis=0), blocks.hi[b])


@pytest.mark.parametrize("made", ["scattered", "in a plane", "at one place", "on a coarse grid"])
def test_the_tree_finds_what_is_near(tmp_path: Path, made: str) -> None:
    rng = np.random.default_rng(3)
    xyz = rng.uniform(-2, 2, (3000, 3)).astype(np.float32)
    if made == "in a plane":
        xyz[:, 1] = 1e3
    elif made == "at one place":
        xyz[:] = xyz[0]
    elif made == "on a coarse grid":
        xyz = np.rint(xyz)
    put([PointFrame(xyz)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    query = xyz[:50] + rng.uniform(-0.2, 0.2, (50, 3)).astype(np.float32)
    every = np.linalg.norm(stored.xyz.astype(float) - query.astype(float)[:, None], axis=2)
    distance, nearest = stored.kdtree.query(query)
    assert distance == pytest.approx(every.min(axis=1))
    assert every[np.arange(50), nearest] == pytest.approx(distance)
    for found, away in zip(stored.kdtree.query_ball_point(query, 0.5), every, strict=True):
        assert sorted(found) == np.flatnonzero(away <= 0.5).tolist()
    assert stored.kdtree is open_sequence(tmp_path / "s")[0].kdtree


@pytest.mark.parametrize("count", [0, 1, 2, 255, 257])
def test_small_and_bare_frames(tmp_path: Path, count: int) -> None:
    xyz = np.full((count, 3), 1.5, np.float32)
    manifest = put([PointFrame(xyz), PointFrame(xyz[:0])], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.source_xyz().tobytes() == xyz.tobytes()
    assert stored.rgb is None
    assert stored.kdtree.n == count
    assert len(stored.blocks.lo) == -(-count // 256)
    assert_wire(stored, manifest)
    assert manifest.fields == ["xyz"]


def test_intensity_serves_as_grey_and_states_its_range(tmp_path: Path) -> None:
    values = np.linspace(0, 4000, 1000).astype(np.float32)
    xyz = np.random.default_rng(0).normal(size=(1000, 3)).astype(np.float32)
    manifest = put([PointFrame(xyz, intensity=values)], tmp_path / "s")
    assert manifest.intensity_range is not None
    low, high = manifest.intensity_range
    stored = open_sequence(tmp_path / "s")[0]
    decoded = decode_points(stored.wire(0, 1), stored.count)
    assert stored.intensity is not None
    unit = np.clip((stored.intensity - low) / (high - low), 0, 1) * 255
    assert np.abs(decoded[:, 9] - unit).max() <= 0.51
    assert not decoded[:, 6:9].any()  # the page's sign to show the intensity as grey


def test_camera_and_pixels_are_kept(tmp_path: Path) -> None:
    camera = DepthCamera(64, 48, 60.0, 61.0, 32.0, 24.0)
    pixel = np.random.default_rng(0).permutation(64 * 48)[:900].astype(np.uint32)
    xyz = np.random.default_rng(1).normal(size=(900, 3)).astype(np.float32)
    put([PointFrame(xyz, camera=camera, pixel=pixel)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    kept = stored.camera
    assert kept is not None
    assert (kept.width, kept.height, kept.fy, kept.cx) == (64, 48, 61.0, 32.0)
    assert stored.pixel is not None
    assert np.array_equal(stored.to_source(stored.pixel), pixel)


@pytest.mark.parametrize("index", [-1, 2, 10**9])
def test_frames_out_of_range_are_not_found(tmp_path: Path, index: int) -> None:
    put([frame(10), frame(10)], tmp_path / "s")
    with pytest.raises(NotFoundError, match="from 0 to 1"):
        open_sequence(tmp_path / "s")[index]


def test_arrays_are_read_only(tmp_path: Path) -> None:
    put([frame(10)], tmp_path / "s")
    stored = open_sequence(tmp_path / "s")[0]
    with pytest.raises(ValueError, match="read-only"):
        stored.xyz[0] = 0


# ── all or nothing ───────────────────────────────────────────────────────────────────────────


def test_a_reader_that_fails_leaves_nothing(tmp_path: Path) -> None:
    def broken() -> Iterator[PointFrame]:
        yield from (frame(1000, seed) for seed in range(5))
        raise BadInputError("frame 5: expected 12 bytes, got 3")

    with pytest.raises(BadInputError, match="frame 5"):
        put(broken(), tmp_path / "s")
    assert list(tmp_path.iterdir()) == []


def test_cancelling_and_no_frames_leave_nothing(tmp_path: Path) -> None:
    def cancel(fraction: float, message: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        import_frames([frame(10)], tmp_path / "s", RecordingInfo("s", "n", 1), progress=cancel)
    with pytest.raises(BadInputError, match="at least one frame"):
        put([], tmp_path / "s")
    with pytest.raises(BadInputError, match="positive"):
        import_frames([frame(10)], tmp_path / "s", RecordingInfo("s", "n", float("nan")))
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_said_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, data: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(importer_module, "write_file", full)
    with pytest.raises(UnavailableError, match="room on disk"):
        put([frame(10)], tmp_path / "s")
    assert list(tmp_path.iterdir()) == []


def test_an_existing_sequence_is_never_replaced(tmp_path: Path) -> None:
    first = put([frame(10)], tmp_path / "s")
    with pytest.raises(ConflictError, match="exists"):
        put([frame(20)], tmp_path / "s")
    assert read_manifest(tmp_path / "s") == first
    assert len(list(tmp_path.iterdir())) == 1


def import_slowly(target: Path) -> None:
    def frames() -> Iterator[PointFrame]:
        while True:
            yield frame(100)
            print("frame", flush=True)
            time.sleep(0.02)

    import_frames(frames(), target, RecordingInfo("s", "n", 30))


def test_a_killed_import_leaves_no_sequence_and_is_swept(tmp_path: Path) -> None:
    target = tmp_path / "s"
    with forked.calling(import_slowly, target) as child:
        for _ in range(4):
            assert child.stdout.readline() == "frame\n"
        left = list(tmp_path.iterdir())
        assert len(left) == 1
        assert clean_temporary(tmp_path) == []  # still running: not ours to remove
    assert not target.exists()
    eventually(lambda: clean_temporary(tmp_path))
    assert list(tmp_path.iterdir()) == []


# ── check ────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("name", ["frames/000001.points", "frames/000001.wire", "manifest.json"])
def test_a_flipped_byte_is_found(tmp_path: Path, name: str) -> None:
    put([frame(500), frame(500)], tmp_path / "s")
    file = tmp_path / "s" / name
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    problems = verify(tmp_path / "s")
    assert len(problems) == 1
    assert Path(name).name.split(".")[0] in problems[0] or "manifest" in problems[0]


def test_missing_and_foreign_files_are_found(tmp_path: Path) -> None:
    put([frame(500)], tmp_path / "s")
    (tmp_path / "s" / "frames" / "000000.wire").unlink()
    (tmp_path / "s" / "frames" / "notes.txt").write_text("mine")
    problems = verify(tmp_path / "s")
    assert any("000000.wire" in problem and "missing" in problem for problem in problems)
    assert any("notes.txt" in problem for problem in problems)
    (tmp_path / "s" / "checksums.json").write_text("{")
    assert any("checksums.json" in problem for problem in verify(tmp_path / "s"))
    assert verify(tmp_path / "absent")
    with pytest.raises(NotFoundError):
        open_sequence(tmp_path / "absent")


def test_damaged_files_are_refused_when_opened(tmp_path: Path) -> None:
    put([frame(500)], tmp_path / "s")
    file = tmp_path / "s" / "frames" / "000000.points"
    whole = file.read_bytes()
    for broken in (b"", whole[:30], b"x" + whole[1:], whole[: len(whole) // 2]):
        file.write_bytes(broken)
        with pytest.raises(DamagedError, match="frame 0 is damaged"):
            open_sequence(tmp_path / "s")[0]
    file.unlink()
    with pytest.raises(DamagedError, match=r"expected the file 000000\.points"):
        open_sequence(tmp_path / "s")[0]
    (tmp_path / "s" / "manifest.json").write_text(json.dumps({"version": 1, "id": "s"}))
    with pytest.raises(BadInputError, match="manifest"):
        open_sequence(tmp_path / "s")


def test_a_newer_manifest_is_refused_in_words(tmp_path: Path) -> None:
    put([frame(500)], tmp_path / "s")
    manifest = tmp_path / "s" / "manifest.json"
    content = json.loads(manifest.read_bytes()) | {"version": VERSION + 1}
    manifest.write_text(json.dumps(content))
    with pytest.raises(BadInputError, match=f"1 to {VERSION}, got {VERSION + 1}, of a newer"):
        open_sequence(tmp_path / "s")


def test_a_depth_camera_s_frame_takes_at_most_22_bytes_a_point_on_disk(tmp_path: Path) -> None:
    made = next(iter(generate("juggling", frames=1).frames))
    put([made], tmp_path / "s")
    used = sum(path.stat().st_size for path in (tmp_path / "s").rglob("*") if path.is_file())
    assert used <= 22 * len(made)
    stored = open_sequence(tmp_path / "s")[0]
    assert stored.rgb is not None
    assert np.array_equal(stored.to_source(stored.rgb), made.rgb)
    assert stored.source_xyz().tobytes() == made.xyz.tobytes()


def test_name_rate_and_room_may_change_and_nothing_else(tmp_path: Path) -> None:
    before = put([frame(500)], tmp_path / "s")
    room = np.eye(4)
    room[:3, 3] = 1, 2, 3
    after = update_manifest(tmp_path / "s", name="Other", fps=15.0, room=room)
    assert read_manifest(tmp_path / "s") == after
    assert (after.name, after.fps, after.points) == ("Other", 15.0, before.points)
    assert np.array_equal(after.T_room_local, room)
    assert verify(tmp_path / "s") == []
    flat = np.diag([1.0, 0, 1, 1])
    for bad in ({"name": " "}, {"fps": 0.0}, {"fps": float("inf")}, {"room": np.eye(3)}):
        with pytest.raises(BadInputError, match="expected"):
            update_manifest(tmp_path / "s", **bad)  # type: ignore[arg-type]
    for matrix in (flat, np.full((4, 4), np.nan), np.ones((4, 4))):
        with pytest.raises(BadInputError, match="room: expected"):
            update_manifest(tmp_path / "s", room=matrix)
    assert read_manifest(tmp_path / "s") == after
