"""A chunk keeps its budget of bytes, its error, and every point once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.frame import PointFrame
from pointbrush.sequences.columns import encode_frame
from pointbrush.sequences.octree.grid import GridChooser
from pointbrush.sequences.octree.order import morton_order
from pointbrush.sequences.octree.quantise import ROOM_STEP, coarsest_step
from pointbrush.sequences.wire.budget import BUDGET, FEW
from pointbrush.sequences.wire.chunk import Grid, encode_chunk
from pointbrush.sequences.wire.path import short_path
from tests.depth_camera import depth_camera
from tests.sequences.vertex_decoder import decode_points, dequantise


def lidar(beams: int, turn: int, *, colour: bool, seed: int = 0) -> PointFrame:
    """A turn of a spinning lidar on a street: ground, walls, 2 cm of noise, intensity."""
    rng = np.random.default_rng(seed)
    up, round_ = np.meshgrid(
        np.radians(np.linspace(-25, 3, beams)), np.linspace(0, 2 * np.pi, turn, endpoint=False)
    )
    ray = np.stack([np.cos(up) * np.cos(round_), np.cos(up) * np.sin(round_), np.sin(up)], -1)
    ray = ray.reshape(-1, 3)
    with np.errstate(divide="ignore"):
        reach = np.where(ray[:, 2] < 0, -1.8 / ray[:, 2], np.inf)
    for axis, at in ((0, 14.0), (0, -9.0), (1, 60.0), (1, -45.0)):
        with np.errstate(divide="ignore"):
            wall = at / ray[:, axis]
        reach = np.where((wall > 0) & (wall < reach), wall, reach)
    xyz = (ray * (reach + rng.normal(0, 0.02, len(reach)))[:, None]).astype(np.float32)
    intensity = np.rint(40 + 20 * np.sin(xyz[:, 0]) + rng.normal(0, 6, len(xyz))).clip(0, 255)
    light = 110 + 40 * np.sin(xyz @ [0.3, 0.4, 0.8]) + rng.normal(0, 10, len(xyz))
    rgb = light[:, None] + [20, 0, -15] + rng.normal(0, 2, xyz.shape)
    return PointFrame(
        xyz,
        rgb.clip(0, 255).astype(np.uint8) if colour else None,
        intensity=intensity.astype(np.float32),
    )


@pytest.mark.parametrize(("beams", "turn"), [(16, 1800), (32, 900), (64, 512)])
@pytest.mark.parametrize("colour", [False, True])
def test_a_sparse_lidar_takes_six_bytes_a_point_and_keeps_its_error(
    beams: int, turn: int, colour: bool
) -> None:
    frame = lidar(beams, turn, colour=colour)
    encoded = encode_frame(frame, GridChooser()([frame]))
    xyz, chunks = encoded.arrays["xyz"], encoded.arrays["chunks"]
    assert len(encoded.wire) <= BUDGET * len(frame)
    assert encoded.error <= 0.0079  # half of 1/64 m, under such a sensor's noise
    assert np.array_equal(np.sort(encoded.arrays["source_index"]), np.arange(len(frame)))
    assert np.array_equal(xyz, frame.xyz[encoded.arrays["source_index"]])
    for chunk in chunks:
        data = encoded.wire[chunk["offset"] : chunk["offset"] + chunk["nbytes"]]
        vertices = decode_points(data, int(chunk["count"]))
        run = slice(chunk["first"], chunk["first"] + chunk["count"])
        q = np.ascontiguousarray(vertices[:, :6]).view(np.uint16)
        back = dequantise(q, chunk["origin"], chunk["scale"])
        assert np.abs(back.astype(float) - xyz[run]).max() <= encoded.error
        assert np.array_equal(vertices[:, 9], encoded.arrays["intensity"][run])
        expected = encoded.arrays["rgb"][run] if colour else np.zeros((len(q), 3))
        assert np.array_equal(vertices[:, 6:9], expected)


def test_blocks_stay_as_small_as_on_the_curve() -> None:
    """A shorter way through the points must not cost selection its culling."""
    frame = lidar(32, 900, colour=True)
    grid = Grid(np.zeros(3), ROOM_STEP, (0.0, 255.0))
    shortened = encode_frame(frame, grid)
    plain = PointFrame(frame.xyz)  # nothing to save: the points stay on the curve
    curve = encode_frame(plain, grid)
    for name in ("block_lo", "block_hi", "block_first"):
        assert np.array_equal(shortened.arrays[name], curve.arrays[name])
    assert not np.array_equal(shortened.arrays["xyz"], curve.arrays["xyz"])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_room_keeps_its_millimetre_and_its_colours(seed: int) -> None:
    frame = depth_camera(seed)
    encoded = encode_frame(frame, GridChooser()([frame]))
    assert encoded.error <= 0.0005
    table = encoded.arrays["chunks"]
    assert table["nbytes"].sum() <= BUDGET * len(frame) * 1.1, "kept in the order of its pixels"
    for chunk in table:
        data = encoded.wire[chunk["offset"] : chunk["offset"] + chunk["nbytes"]]
        run = slice(chunk["first"], chunk["first"] + chunk["count"])
        shown = decode_points(data, int(chunk["count"]))[:, 6:9]
        assert np.array_equal(shown, encoded.arrays["rgb"][run])


@st.composite
def clouds(draw: st.DrawFn) -> PointFrame:
    """Anything from a surface with smooth colours to noise with noise, of any size and place."""
    count = draw(st.integers(FEW, 9000))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    extent = 10.0 ** draw(st.floats(-2, 3.5))
    xyz = rng.uniform(-extent / 2, extent / 2, (count, 3))
    xyz[:, draw(st.integers(0, 2))] *= draw(st.sampled_from([0, 1e-3, 0.1, 1]))
    if draw(st.booleans()):  # clumps
        xyz = 0.01 * xyz + xyz[rng.integers(0, max(1, count // 50), count)]
    if draw(st.booleans()):
        xyz += rng.uniform(-900, 900, 3)
    fog = rng.uniform(0, 255, (count, 3)) * draw(st.sampled_from([0.02, 0.3, 1]))
    shade = 100 + 90 * np.sin(9 * xyz[:, :1] / extent)
    rgb = ((shade + fog).clip(0, 255)).astype(np.uint8) if draw(st.booleans()) else None
    intensity = rng.uniform(0, 255, count).astype(np.float32) if draw(st.booleans()) else None
    return PointFrame(xyz.astype(np.float32), rgb, intensity=intensity)


@given(clouds())
def test_every_level_of_any_cloud_keeps_the_budget_and_the_stated_error(frame: PointFrame) -> None:
    encoded = encode_frame(frame, GridChooser()([frame]))
    xyz, rgb = encoded.arrays["xyz"], encoded.arrays.get("rgb")
    assert np.array_equal(np.sort(encoded.arrays["source_index"]), np.arange(len(frame)))
    for chunk in encoded.arrays["chunks"]:
        count = int(chunk["count"])
        # Whatever comes of a frame is a prefix of its chunks.
        assert chunk["offset"] + chunk["nbytes"] <= BUDGET * (chunk["first"] + count)
        data = encoded.wire[chunk["offset"] : chunk["offset"] + chunk["nbytes"]]
        vertices = decode_points(data, count)
        run = slice(chunk["first"], chunk["first"] + count)
        q = np.ascontiguousarray(vertices[:, :6]).view(np.uint16)
        back = dequantise(q, chunk["origin"], chunk["scale"])
        assert np.abs(back.astype(float) - xyz[run]).max() <= encoded.error
        if rgb is not None:
            assert np.abs(vertices[:, 6:9].astype(int) - rgb[run].astype(int)).max() <= 8
            assert np.array_equal(vertices[:, 6:9].any(axis=1), rgb[run].any(axis=1))


@pytest.mark.parametrize(
    ("extent", "step"),
    [(0.3, 2**-14), (3.0, ROOM_STEP), (30.0, 2**-8), (100.0, 2**-6), (3e3, 2**-4)],
)
def test_how_coarse_a_grid_may_become(extent: float, step: float) -> None:
    assert coarsest_step(extent) == step


@pytest.mark.parametrize("related", [False, True])
def test_colours_come_back_whether_they_are_alike_or_not(related: bool) -> None:
    rng = np.random.default_rng(1)
    colors = rng.integers(0, 256, (3000, 4), np.uint8)
    if related:
        colors[:, 0], colors[:, 2] = colors[:, 1] + 200, colors[:, 1] // 2
    xyz = np.zeros((3000, 3), np.float32)
    chunk = encode_chunk(xyz, colors, Grid(np.zeros(3), ROOM_STEP, None))
    expected = colors if chunk.order is None else colors[chunk.order]
    assert np.array_equal(decode_points(chunk.data, 3000)[:, 6:10], expected)


@pytest.mark.parametrize(("noise", "coarsest", "most"), [(32, 2.0**-6, 3), (256, 0.0, 8)])
def test_colours_lose_their_noise_and_what_is_black_stays_black(
    noise: int, coarsest: float, most: int
) -> None:
    """A lidar's colours a low bit or two; where all is noise, also a room's, up to three bits."""
    rng = np.random.default_rng(4)
    colors = rng.integers(256 - noise, 256, (3000, 4), np.uint8)
    colors[:, 3] //= 16
    colors[::7, :3] = 0
    colors[1::7, :3] = [[1, 0, 3]]
    xyz = rng.uniform(-20, 20, (3000, 3)).astype(np.float32)
    grid = Grid(np.zeros(3), ROOM_STEP, None, coarsest)
    chunk = encode_chunk(xyz[morton_order(xyz)], colors, grid)
    order = np.arange(3000) if chunk.order is None else chunk.order
    found, given = decode_points(chunk.data, 3000)[:, 6:10].astype(int), colors[order].astype(int)
    assert np.array_equal(found[:, 3], given[:, 3])
    assert most // 2 < np.abs(found - given).max() <= most
    # Black says that no camera saw the point.
    assert np.array_equal(found[:, :3].any(axis=1), given[:, :3].any(axis=1))
    assert found[:, :3].max() == 255
    assert len(chunk.data) <= BUDGET * 3000


@given(st.integers(0, 2**32 - 1), st.integers(0, 900), st.integers(1, 7))
def test_a_short_way_meets_every_point_once_and_stays_in_its_block(
    seed: int, count: int, fields: int
) -> None:
    values = np.random.default_rng(seed).integers(-(2**15), 2**16, (fields, count), np.int32)
    way = short_path(values)
    assert np.array_equal(np.sort(way), np.arange(count))
    parts = -(-count // 256)
    for part in range(parts):
        first, stop = part * count // parts, (part + 1) * count // parts
        assert np.array_equal(np.sort(way[first:stop]), np.arange(first, stop))
