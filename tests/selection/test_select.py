"""Selection against the definition of each shape, tested point by point."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from pointbrush.errors import BadInputError
from pointbrush.selection import Points, Selector, Stroke, first_hits, select
from pointbrush.selection import points as selected_points
from pointbrush.sequences.blocks import Blocks, bound, cut
from pointbrush.streaming.messages import Brush

SEEDS = st.integers(0, 2**32 - 1)


def indexed(xyz: NDArray[np.float32], rgb: NDArray[np.uint8] | None = None) -> Points:
    """Points in the order given, with blocks over it."""
    chunk_first = np.unique([0, *range(1000, len(xyz), 1000), len(xyz)]).astype(np.int64)
    first, chunk_block = cut(chunk_first)
    lo, hi = bound(xyz, first)
    chunk_lo, chunk_hi = bound(xyz, chunk_first)
    blocks = Blocks(first, lo, hi, chunk_block, chunk_lo, chunk_hi)
    return Points(xyz, blocks, rgb, (0,), lambda: cKDTree(xyz))


def cloud(seed: int, n: int = 3000) -> tuple[np.random.Generator, NDArray[np.float32]]:
    rng = np.random.default_rng(seed)
    return rng, rng.uniform(-1, 1, (n, 3)).astype(np.float32)


def stroke(shape: str, origins: object, directions: object = None, **fields: object) -> Stroke:
    origins = np.atleast_2d(np.asarray(origins, float))
    if directions is None:
        directions = np.tile([0.0, 0.0, -1.0], (len(origins), 1))
    samples = [
        {"origin": o.tolist(), "direction": d.tolist()}
        for o, d in zip(origins, np.atleast_2d(np.asarray(directions, float)), strict=True)
    ]
    return Stroke.parse({"label": 1, "shape": shape, "samples": samples, **fields})


def to_segment(
    xyz: NDArray[np.float32], a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distances to a segment, written the plain way."""
    t = np.clip(((xyz - a) @ (b - a)) / max(float((b - a) @ (b - a)), 1e-300), 0, 1)
    return np.linalg.norm(xyz - (a + t[:, None] * (b - a)), axis=1)


@given(SEEDS, st.integers(1, 6), st.floats(0.02, 0.7))
def test_sphere_is_the_swept_ball(seed: int, samples: int, radius: float) -> None:
    rng, xyz = cloud(seed)
    path = rng.uniform(-1, 1, (samples, 3))
    nearest = np.min(
        [to_segment(xyz, a, b) for a, b in zip(path, [*path[1:], path[-1]], strict=True)], axis=0
    )
    got = select(indexed(xyz), stroke("sphere", path, radius=radius))
    assert set(got) >= set(np.flatnonzero(nearest < radius * (1 - 1e-6)))
    assert set(got) <= set(np.flatnonzero(nearest <= radius * (1 + 1e-6)))
    assert (np.diff(got) > 0).all()


@given(SEEDS, st.floats(0.02, 0.4))
def test_ray_through_takes_everything_near_the_half_line(seed: int, radius: float) -> None:
    rng, xyz = cloud(seed)
    origin, direction = rng.uniform(-2, 2, 3), rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    along = (xyz - origin) @ direction
    off = np.linalg.norm(xyz - origin - along[:, None] * direction, axis=1)
    got = select(indexed(xyz), stroke("ray", origin, direction, radius=radius, through=True))
    assert set(got) == set(np.flatnonzero((along >= 0) & (off <= radius)))


@given(SEEDS)
def test_ray_paints_the_first_of_two_walls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wall = np.column_stack([rng.uniform(-1, 1, (4000, 2)), np.full(4000, -1.0)])
    xyz = np.concatenate([wall, wall * [1, 1, 2]]).astype(np.float32)
    aim = rng.uniform(-0.5, 0.5, 2)
    got = select(indexed(xyz), stroke("ray", [*aim, 1.0], radius=0.1))
    off = np.linalg.norm(xyz[:, :2] - aim, axis=1)
    assert set(got) <= set(np.flatnonzero((xyz[:, 2] > -1.5) & (off <= 0.1 + 1e-6)))
    assert set(got) >= set(np.flatnonzero((xyz[:, 2] > -1.5) & (off <= 0.09)))


def test_ray_axis_aligned_in_a_border_plane_still_hits() -> None:
    xyz = np.array([[0, 0, -1], [0, 0.001, -1], [1, 0, -2]], np.float32)
    assert select(indexed(xyz), stroke("ray", [0, 0, 0], [0, 0, -1], radius=0.05)).tolist() == [
        0,
        1,
    ]


def test_ray_goes_through_what_is_deleted() -> None:
    xyz = np.array([[0, 0, -1], [0, 0, -2]], np.float32)
    ray = stroke("ray", [0, 0, 0], radius=0.05)
    hit = first_hits(indexed(xyz), ray.origins, ray.directions, 0.05, lambda n: n != 0)
    assert hit[0].tolist() == pytest.approx([0, 0, -2])


def test_ray_into_the_void_takes_nothing() -> None:
    _, xyz = cloud(3)
    assert len(select(indexed(xyz), stroke("ray", [0, 0, 5], [0, 0, 1], radius=0.1))) == 0


@pytest.mark.parametrize("far", [1e160, -1e300])
@pytest.mark.parametrize("way", [[0, 0, 1], [1e-310, 0, 1], [1, 1e-200, 1e-300]])
def test_rays_from_as_far_as_numbers_go_meet_nothing(far: float, way: list[float]) -> None:
    _, xyz = cloud(3)
    assert len(select(indexed(xyz), stroke("ray", [far, far, 5], way, radius=0.1))) == 0


@given(SEEDS, st.sampled_from(["ray", "grow", "plane"]), st.floats(0.02, 0.3), st.booleans())
def test_many_rays_together_are_each_of_them_alone(
    seed: int, shape: str, radius: float, far: bool
) -> None:
    rng, xyz = cloud(seed, 2000)
    # Far from zero, where float32 and products of matrices round most.
    xyz += np.float32(500 if far else 0)
    origins = rng.uniform(-2, 2, (40, 3)) + (500 if far else 0)
    directions = rng.normal(size=(40, 3)) * [1, 1, 1 if seed % 2 else 0]
    rays = stroke(shape, origins, directions, radius=radius)
    points = indexed(xyz)

    def alive(numbers: NDArray[np.int64]) -> NDArray[np.bool_]:
        return numbers % 3 > 0

    together = first_hits(points, rays.origins, rays.directions, radius, alive)
    for k in range(40):
        along = (xyz - rays.origins[k]) @ rays.directions[k]
        off = np.linalg.norm(xyz - rays.origins[k] - along[:, None] * rays.directions[k], axis=1)
        alone = first_hits(
            points, rays.origins[k : k + 1], rays.directions[k : k + 1], radius, alive
        )
        np.testing.assert_allclose(together[k], alone[0], atol=1e-9)
        met = (along > 0) & (off <= radius) & alive(np.arange(len(xyz)))
        assert np.isfinite(together[k, 0]) == met.any()
        if met.any():
            assert along[met].min() - 1e-9 <= (together[k] - rays.origins[k]) @ rays.directions[k]
    # Drawn in batches, the same points come as at once.
    selector = Selector(points, replace(rays, origins=rays.origins[:0]), alive)
    for cut_at in (slice(0, 7), slice(7, 23), slice(23, 40)):
        batch = replace(rays, origins=rays.origins[cut_at], directions=rays.directions[cut_at])
        for _ in selector.add(batch):
            pass
    drawn = np.concatenate([np.empty(0, np.int64), *selector.taken.parts()])
    np.testing.assert_array_equal(drawn, select(points, rays, alive))
    if shape == "ray":
        hits = together[np.isfinite(together[:, 0])]
        near = np.linalg.norm(xyz[:, None] - hits[None], axis=2).min(axis=1, initial=np.inf)
        assert set(drawn) >= set(np.flatnonzero(near < radius * (1 - 1e-6)))
        assert set(drawn) <= set(np.flatnonzero(near <= radius * (1 + 1e-6)))


@given(SEEDS)
def test_box_is_every_point_inside(seed: int) -> None:
    rng, xyz = cloud(seed)
    turn = Rotation.from_quat(rng.normal(size=4))
    center, size = rng.uniform(-0.5, 0.5, 3), rng.uniform(0.05, 1.5, 3)
    inside = (np.abs(turn.inv().apply(xyz - center)) <= size / 2).all(axis=1)
    fields = {
        "center": center.tolist(),
        "size": size.tolist(),
        "quaternion": turn.as_quat().tolist(),
    }
    got = select(indexed(xyz), Stroke.parse({"label": 1, "shape": "box", **fields}))
    assert set(got) == set(np.flatnonzero(inside))


@given(SEEDS)
def test_lasso_is_every_point_that_projects_inside(seed: int) -> None:
    rng, xyz = cloud(seed)
    near, far, f = 0.1, 10.0, 1.3
    projection = np.array(
        [
            [f, 0, 0, 0],
            [0, f, 0, 0],
            [0, 0, (far + near) / (near - far), 2 * far * near / (near - far)],
            [0, 0, -1, 0],
        ]
    )
    view = np.eye(4)
    view[:3, :3] = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    view[:3, 3] = [0, 0, -1.5]
    matrix = projection @ view
    x, y, w, h = *rng.uniform(-0.6, 0.2, 2), *rng.uniform(0.1, 0.8, 2)
    polygon = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]]
    clip = np.column_stack([xyz, np.ones(len(xyz))]) @ matrix.T
    ndc = clip[:, :2] / clip[:, 3:]
    inside = (clip[:, 3] > 0) & (clip[:, 2] >= -clip[:, 3])
    inside &= ((ndc > [x, y]) & (ndc < [x + w, y + h])).all(axis=1)
    fields = {"polygon": polygon, "matrix": matrix.ravel().tolist()}
    got = select(indexed(xyz), Stroke.parse({"label": 1, "shape": "lasso", **fields}))
    assert set(got) == set(np.flatnonzero(inside))


def test_lasso_knows_concave_polygons() -> None:
    xyz = np.array([[0, 0.5, 0], [0.5, -0.5, 0]], np.float32)
    u_shape = [[-1, -1], [1, -1], [1, 1], [0.2, 1], [0.2, 0], [-0.2, 0], [-0.2, 1], [-1, 1]]
    fields = {"polygon": u_shape, "matrix": np.eye(4).ravel().tolist()}
    assert select(
        indexed(xyz), Stroke.parse({"label": 1, "shape": "lasso", **fields})
    ).tolist() == [1]


def two_plates(rng: np.random.Generator, gap: float) -> tuple[NDArray[np.float32], int]:
    u = rng.uniform(0, 0.5, (6000, 2))
    left = np.column_stack([u - [0.5 + gap, 0], np.zeros(6000)])
    right = np.column_stack([u, np.zeros(6000)])
    return np.concatenate([left, right]).astype(np.float32), 6000


def test_grow_stops_at_a_gap() -> None:
    xyz, n = two_plates(np.random.default_rng(0), gap=0.1)
    got = select(indexed(xyz), stroke("grow", [0.25, 0.25, 1], radius=0.05))
    assert got.min() >= n
    assert len(got) > 0.99 * n


def test_grow_stops_at_another_colour() -> None:
    xyz, n = two_plates(np.random.default_rng(1), gap=0.0)
    rgb = np.repeat(np.array([[200, 30, 30], [30, 30, 200]], np.uint8), n, axis=0)
    got = select(indexed(xyz, rgb), stroke("grow", [0.25, 0.25, 1], radius=0.05))
    assert got.min() >= n
    assert len(got) > 0.99 * n


def test_grow_stops_at_a_corner() -> None:
    rng = np.random.default_rng(2)
    u = rng.uniform(0, 0.5, (8000, 2))
    floor = np.column_stack([u, np.zeros(8000)])
    wall = np.column_stack([np.zeros(8000), u])
    xyz = np.concatenate([floor, wall]).astype(np.float32)
    got = select(indexed(xyz), stroke("grow", [0.3, 0.3, 1], radius=0.05))
    assert (got < 8000).sum() > 0.95 * 8000
    assert (got >= 8000).sum() < 0.1 * 8000


@given(SEEDS, st.sampled_from(["sphere", "ray"]), st.integers(1, 7))
def test_batches_of_samples_take_what_the_whole_stroke_takes(
    seed: int, shape: str, batch: int
) -> None:
    rng, xyz = cloud(seed)
    points = indexed(xyz)
    whole = stroke(shape, rng.uniform(-1, 1, (12, 3)), rng.normal(size=(12, 3)), radius=0.15)
    selector = Selector(points, stroke(shape, np.empty((0, 3)), radius=0.15))
    fresh = []
    for start in range(0, 12, batch):
        some = stroke(
            shape,
            whole.origins[start : start + batch],
            whole.directions[start : start + batch],
            radius=0.15,
        )
        fresh.extend(selector.add(some))
    taken = np.concatenate(list(selector.taken.parts()))
    assert taken.tolist() == select(points, whole).tolist()
    assert np.sort(np.concatenate(fresh)).tolist() == taken.tolist()


@pytest.mark.parametrize("shape", ["sphere", "ray", "tube", "lasso", "box", "plane"])
def test_a_scan_looked_at_in_groups_gives_the_same(
    shape: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(9)
    xyz = rng.uniform(-1, 1, (30_000, 3)).astype(np.float32)
    xyz[::2, 2] = rng.normal(0, 0.004, 15_000)
    points, released = indexed(xyz), []
    fields: dict[str, object] = {"label": 1, "shape": shape, "radius": 0.4}
    aim = {"origin": [0.1, 0.2, 2.0], "direction": [0.05, 0.0, -1.0]}
    match shape:
        case "lasso":
            polygon = [[-0.5, -0.6], [0.7, -0.2], [0.1, 0.8]]
            fields |= {"polygon": polygon, "matrix": np.eye(4).tolist()}
        case "box":
            fields |= {"center": [0, 0, 0], "size": [1.0, 1.5, 0.7]}
        case "tube":
            fields |= {"shape": "ray", "through": True, "samples": [aim]}
        case "sphere":
            fields |= {"samples": [{"origin": [-0.5, 0, 0]}, {"origin": [0.5, 0.3, 0]}]}
        case _:
            fields |= {"samples": [aim]}
    brush = Stroke.parse(fields)
    at_once = select(points, brush)
    monkeypatch.setattr(selected_points, "GROUP_POINTS", 1_000)
    grouped = replace(points, release=lambda: released.append(1))
    assert select(grouped, brush).tolist() == at_once.tolist()
    assert len(at_once) > 200
    assert released


@pytest.mark.parametrize("shape", ["sphere", "ray", "grow", "plane"])
def test_an_empty_frame_gives_nothing(shape: str) -> None:
    xyz = np.empty((0, 3), np.float32)
    assert len(select(indexed(xyz), stroke(shape, [0, 0, 0], radius=0.1))) == 0


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"shape": "blob"}, "shape"),
        ({"tool": "burn"}, "tool"),
        ({"label": 0}, "erase"),
        ({"samples": [{"origin": [0, 0], "direction": [0, 0, 1]}]}, "origin"),
        ({"samples": [{"origin": [0, 0, float("inf")]}]}, "origin"),
        ({"samples": [{"origin": [0, 0, 0], "direction": [0, 0, 0]}]}, "direction"),
        ({"shape": "lasso", "polygon": [[0, 0], [1, 1]]}, "polygon"),
        ({"shape": "lasso", "polygon": [[0, 0], [1, 1], [1, 0]]}, "matrix"),
        ({"shape": "box", "center": [0, 0, 0], "size": [1, 0, 1]}, "size"),
        ({"shape": "box", "size": [1, 1, 1]}, "center"),
    ],
)
def test_bad_strokes_say_what_was_expected(fields: dict[str, object], says: str) -> None:
    with pytest.raises(BadInputError, match=says):
        Stroke.parse({"label": 1, "shape": "sphere", **fields})


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"radius": -1}, "radius"),
        ({"radius": float("nan")}, "radius"),
        ({"label": 70000}, "65534"),
        ({"level": 6}, "level"),
        ({"polygon": [[0, 0, 0]]}, "polygon"),
        *(
            ({"hidden": hidden}, "hidden")
            for hidden in (3, [70_000], [-1], ["a"], [[1]], [1.5], [1] * 65_536)
        ),
        ({"frames": [-1]}, "frames"),
        ({"frames": [0] * 1001}, "at most 1000"),
        ({"clip": [1, 2]}, "clip"),
        ({"clip": {"center": [0, 0, 0], "size": [1, 1, 1], "roll": 2}}, "roll"),
    ],
)
def test_calls_and_messages_check_numbers(fields: dict[str, object], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        Brush.model_validate({"label": 1, "shape": "sphere", **fields})


def test_a_sampled_shape_needs_samples() -> None:
    _, xyz = cloud(0)
    with pytest.raises(BadInputError, match="at least one"):
        select(indexed(xyz), stroke("ray", np.empty((0, 3))))


def test_strokes_move_to_local_coordinates() -> None:
    shift = np.array([500_000.0, 4_000_000.0, 100.0])
    _, xyz = cloud(5)
    here = stroke("sphere", [0.1, 0.2, 0.3], radius=0.4)
    there = stroke("sphere", np.array([0.1, 0.2, 0.3]) + shift, radius=0.4).to_local(shift)
    assert select(indexed(xyz), here).tolist() == select(indexed(xyz), there).tolist()


@pytest.mark.parametrize(
    ("shape", "fields"),
    [
        ("sphere", {"radius": 0.6}),
        ("ray", {"radius": 0.2, "through": True}),
        ("ray", {"radius": 0.2}),
        ("box", {"center": [0.2, 0, 0], "size": [1, 2, 1]}),
        ("lasso", {"polygon": [[-1, -1], [1, -1], [0, 1]], "matrix": np.eye(4).ravel().tolist()}),
        ("grow", {"radius": 0.3}),
        ("plane", {"radius": 0.3}),
        ("cluster", {"radius": 0.3}),
    ],
)
@given(SEEDS)
@settings(max_examples=15)
def test_a_clip_box_is_as_if_nothing_lay_outside(
    shape: str, fields: dict[str, object], seed: int
) -> None:
    """A stroke takes of the clipped cloud what it takes where rays meet only the points inside."""
    rng, xyz = cloud(seed, 1500)
    turn = Rotation.from_quat(rng.normal(size=4))
    center, size = rng.uniform(-0.4, 0.4, 3), rng.uniform(0.5, 1.6, 3)
    inside = (np.abs((xyz - center) @ turn.as_matrix()) <= size / 2).all(axis=1)
    clip = {
        "center": center.tolist(),
        "size": size.tolist(),
        "quaternion": turn.as_quat().tolist(),
    }
    rays = rng.uniform(-1, 1, (4, 3)) + [0, 0, 2]
    points = indexed(xyz)
    plain = stroke(shape, rays, **fields)
    clipped = stroke(shape, rays, **fields, clip=clip)
    expected = select(points, plain, lambda numbers: inside[numbers])
    expected = expected[inside[expected]]
    assert select(points, clipped).tolist() == expected.tolist()
    # The same while the stroke is drawn, and after it moved to other coordinates with its points.
    selector = Selector(points, clipped.run(slice(0, 0)))
    for start in range(4):
        list(selector.add(clipped.run(slice(start, start + 1))))
    parts = [np.empty(0, np.int64), *selector.taken.parts()]
    assert np.concatenate(parts).tolist() == expected.tolist()


def test_a_clip_without_a_volume_is_refused() -> None:
    with pytest.raises(BadInputError, match="clip: size: expected 3 lengths above 0"):
        stroke("sphere", [0, 0, 0], clip={"center": [0, 0, 0], "size": [1, 0, 1]})


def test_a_ray_passes_what_flies_beside_it_before_the_surface_of_an_image() -> None:
    """Blocks that reach over an outline are long, and say nothing of the surface's spacing."""
    pitch, side = 1 / 180, 64
    across, down = np.meshgrid(np.arange(side) - side // 2, np.arange(side) - side // 2)
    depth = np.where(across < 0, 2.0, 4.0)
    depth[side // 2, side // 2 + 13] = 3.0
    xyz = np.stack([across * pitch * depth, down * pitch * depth, depth], axis=-1)
    plain = indexed(xyz.reshape(-1, 3).astype(np.float32))
    pixels = SimpleNamespace(eye=(0.0, 0.0, 0.0), axis=2, pitch=(pitch, pitch))
    aim = np.array([0.02, 0.0, 4.0])
    origin = xyz[side // 2, side // 2 + 8] - aim
    ways = [origin[None], (aim / np.linalg.norm(aim))[None], 0.25]
    assert abs(first_hits(replace(plain, pixels=pixels), *ways)[0, 2] - 4.0) < 0.02
    assert first_hits(plain, *ways)[0, 2] < 3.1
