"""Single frames of furnished rooms with the instance of every point.

``room_view``: one view of a depth camera; ``room_scan``: many views joined and thinned, like a
room scanned with a phone or a scanner; ``home_scan``: a scan of a lived-in home with many kinds of
furniture, with less exact poses of views, fused to one smooth surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.errors import BadInputError
from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.samples.geometry import (
    Array,
    Field,
    dot3,
    from_rotation_vector,
    norm3,
    rigid,
    unit,
    vec,
)
from pointbrush.samples.lighting import Lamp, Lights, ambient_light, lamp_light
from pointbrush.samples.render import Caster, Solid
from pointbrush.samples.reproducible import cos, draw_normal, matmul, norms, sin
from pointbrush.samples.sensor import KINECT, Sensor, develop, measure, pixel_rays
from pointbrush.samples.textures import noise
from pointbrush_samples.interior import HOME, Interior

WIDE = DepthCamera(width=288, height=216, fx=190.0, fy=190.0, cx=143.5, cy=107.5)
"""The camera that is carried through a room to scan it."""
NEWTON_STEPS = 12
"""Steps to the least eigenvalue of a neighbourhood's scatter."""
FUSED_AT_ONCE = 20_000
"""Points of one batch of neighbourhoods, which bounds the memory."""
SCAN_NOISE = 0.004
"""Metres; standard deviation of a scan's points along the view."""


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """A frame with the ``instance`` (N,) uint16 of each point, 0 for floor, walls and ground.

    ``T_room_frame`` (4, 4) stands the frame on its floor, y up.
    """

    frame: PointFrame
    instance: NDArray[np.uint16]
    T_room_frame: Array


def look_at(eye: Array, target: Array) -> Array:
    """``T_room_camera`` (4, 4) of a level camera at ``eye`` (x right, y down, z forward)."""
    z = unit(target - eye)
    x = unit(np.cross(z, vec(0, 1, 0)))
    return rigid(np.column_stack([x, np.cross(z, x), z]), eye)


def room_view(seed: int, camera: DepthCamera = KINECT, noise: float = 1.0) -> Labelled:
    """Render a furnished room for a depth camera, camera coordinates."""
    interior = Interior(seed)
    rng = np.random.default_rng([seed, 43])
    w, d = interior.width / 2, interior.depth / 2
    eye = vec(rng.uniform(-0.8, 0.8) * w, rng.uniform(0.9, 1.9), rng.uniform(-0.8, 0.8) * d)
    aim = _somewhere(interior.solids, eye, rng, 3.5)
    return view_of(interior.solids, look_at(eye, aim), camera, Sensor(noise=noise), rng)


def _somewhere(solids: list[Solid], eye: Array, rng: np.random.Generator, reach: float) -> Array:
    """Return the place of a random labelled solid, one within reach if there is any."""
    places = np.array([s.pose[:3, 3] for s in solids if s.label])
    if len(places) == 0:
        return np.asarray(eye + vec(1, -0.3, 0))
    distance = norms(places - eye)
    near = np.flatnonzero((distance < reach) & (distance > 0.9))
    chosen = int(rng.choice(near)) if len(near) else int(distance.argmin())
    return np.asarray(places[chosen] + draw_normal(rng, 0.15, 3))


def view_of(
    solids: list[Solid],
    T_room_camera: Array,
    camera: DepthCamera,
    sensor: Sensor,
    rng: np.random.Generator,
) -> Labelled:
    """Render a depth camera's view of solids in the light of one lamp, camera coordinates."""
    caster = Caster(camera, T_room_camera, pixel_rays(camera))
    seen = caster.empty()
    caster.cast(solids, seen)
    s = caster.shade(solids, seen)
    lights = Lights((Lamp(vec(rng.uniform(-2, 2), 2.2, rng.uniform(-2, 2)), (2.2, 2.1, 2.0), 3),))
    light = np.zeros((3, seen.depth.size), np.float32)
    light[:, s.pixel] = ambient_light(lights, s) + lamp_light(lights.lamps[0], s, caster.eye)
    shape = (camera.height, camera.width)
    amplitude, label = np.zeros(seen.depth.size, np.float32), np.zeros(seen.depth.size, np.uint16)
    rays: Field = caster.room_rays[:, s.pixel]
    amplitude[s.pixel] = s.infrared * np.maximum(-dot3(s.normal, rays) / norm3(rays), 0)
    label[s.pixel] = s.label
    scan = measure(
        sensor,
        seen.depth.reshape(shape),
        label.reshape(shape),
        amplitude.reshape(shape),
        rng,
    )
    picture = develop(sensor, light.reshape(3, *shape), rng)
    pixel = np.flatnonzero(scan.depth > 0)
    xyz = (caster.rays[:, pixel] * scan.depth.ravel()[pixel]).T
    frame = PointFrame(
        np.ascontiguousarray(xyz, np.float32),
        picture.reshape(-1, 3)[pixel],
        viewpoint=np.zeros(3),
        camera=camera,
        pixel=pixel.astype(np.uint32),
    )
    return Labelled(frame, scan.label.ravel()[pixel], T_room_camera)


@dataclass(frozen=True, slots=True)
class ScanOptions:
    """Settings of a scan, and errors of its views."""

    points: int = 200_000
    """Approximate number of points of the scan."""
    views: int = 14
    noise: float = SCAN_NOISE
    """Metres; standard deviation of a point."""
    drift: float = 0.0
    """Metres; standard deviation of a view's place."""
    turn: float = 0.0
    """Radians; standard deviation of a view's direction, about each axis."""
    fused: int = 0
    """Neighbours of a point that give its position along the normal and its colour by their mean:
    fused surfaces are rounded at their edges, and merge where they touch."""
    bumps: float = 0.0
    """Metres; amplitude of the waves of a fused surface."""
    bump_width: float = 0.2
    """Metres; length of the largest of these waves."""

    def check(self) -> None:
        """Raise BadInputError for numbers out of range."""
        if min(self.points, self.views) < 1:
            raise BadInputError("points, views: expected 1 or more")
        if min(self.noise, self.drift, self.turn, self.fused, self.bumps) < 0:
            raise BadInputError("noise, drift, turn, fused, bumps: expected 0 or more")
        if not self.bump_width > 0:
            raise BadInputError(f"bump_width: expected above 0, got {self.bump_width}")


FUSED = ScanOptions(views=18, drift=0.012, turn=0.006, fused=16, bumps=0.008)
"""A scan by a camera that estimates its own poses."""


def room_scan(seed: int, points: int = 200_000, views: int = 14) -> Labelled:
    """Return a furnished room scanned from many views, about ``points`` points, y up."""
    return scan_of(Interior(seed), seed, ScanOptions(points, views))


def home_scan(seed: int, options: ScanOptions = FUSED) -> Labelled:
    """Return a lived-in home scanned from many views and fused, y up."""
    return scan_of(Interior(seed, HOME), seed, options)


def scan_of(interior: Interior, seed: int, options: ScanOptions) -> Labelled:
    """Join many views of a room; raises BadInputError for the options."""
    options.check()
    rng = np.random.default_rng([seed, 47])
    w, d = interior.width / 2 - 0.4, interior.depth / 2 - 0.4
    sensor = Sensor(noise=0.6, nearest=0.3, farthest=9.0)
    xyz, rgb, label = [], [], []
    for k in range(options.views):
        angle = 2 * math.pi * k / options.views + rng.uniform(-0.2, 0.2)
        eye = vec(w * cos(angle), rng.uniform(1.3, 1.8), d * sin(angle))
        aim = vec(-eye[0], rng.uniform(0.1, 1.2), -eye[2]) * rng.uniform(0.1, 0.8)
        if k % 2:
            aim = _somewhere(interior.solids, eye, rng, 5.0)
        made = view_of(interior.solids, look_at(eye, aim), WIDE, sensor, rng)
        T = made.T_room_frame
        if options.drift or options.turn:
            wrong = from_rotation_vector(draw_normal(rng, options.turn, 3))
            T = rigid(matmul(wrong, T[:3, :3]), T[:3, 3] + draw_normal(rng, options.drift, 3))
        room = matmul(made.frame.xyz, T[:3, :3].T) + T[:3, 3]
        xyz.append(room + draw_normal(rng, options.noise, room.shape))
        rgb.append(made.frame.rgb)
        label.append(made.instance)
    every, colours = np.concatenate(xyz), np.concatenate([c for c in rgb if c is not None])
    kept = _thinned(every, options.points, rng)
    places, tints = every[kept], colours[kept]
    if options.fused:
        places, tints = _fused(places, tints, options)
    frame = PointFrame(places.astype(np.float32), tints)
    return Labelled(frame, np.concatenate(label)[kept], np.eye(4))


def _fused(
    xyz: Array, rgb: NDArray[np.uint8], options: ScanOptions
) -> tuple[Array, NDArray[np.uint8]]:
    """Return positions and colours (n, 3) of points moved to the fused surface."""
    tree = cKDTree(xyz, balanced_tree=False, compact_nodes=False)
    near = np.asarray(tree.query(xyz, k=min(options.fused, len(xyz)))[1]).reshape(len(xyz), -1)
    wave = noise(np.asarray(xyz.T, np.float32), options.bump_width) - 0.5
    places, tints = np.empty_like(xyz), np.empty_like(rgb)
    for first in range(0, len(xyz), FUSED_AT_ONCE):
        part = slice(first, first + FUSED_AT_ONCE)
        around = xyz[near[part].T]
        middle = around.mean(axis=0)
        normal = _normals(around - middle)
        # Orient the normals to one side, so that the waves move a surface as a whole.
        normal *= np.where(matmul(normal, vec(0.3, 0.9, 0.4)) < 0, -1.0, 1.0)[:, None]
        lift = ((middle - xyz[part]) * normal).T.sum(axis=0) + 2 * options.bumps * wave[part]
        places[part] = xyz[part] + lift[:, None] * normal
        tints[part] = rgb[near[part]].mean(axis=1).round()
    return places, tints


def _normals(apart: Array) -> Array:
    """Return the directions (N, 3) of least spread of neighbours (K, N, 3) about their middles."""
    x, y, z = np.moveaxis(apart, -1, 0)
    xx, yy, zz, xy, xz, yz = (
        (a * b).sum(axis=0) for a, b in ((x, x), (y, y), (z, z), (x, y), (x, z), (y, z))
    )
    trace = xx + yy + zz
    minors = xx * yy + xx * zz + yy * zz - xy * xy - xz * xz - yz * yz
    determinant = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    least = np.zeros_like(trace)
    for _ in range(NEWTON_STEPS):  # from below to the least root of the characteristic polynomial
        value = ((least - trace) * least + minors) * least - determinant
        slope = (3 * least - 2 * trace) * least + minors
        least -= np.where(slope > 0, value / np.where(slope > 0, slope, 1), 0)
    rows = np.stack([xx - least, xy, xz, xy, yy - least, yz, xz, yz, zz - least], -1)
    rows = rows.reshape(-1, 3, 3)
    across = np.cross(rows, rows[:, [1, 2, 0]])
    size = (across * across).sum(axis=-1)
    longest = np.arange(len(rows)), size.argmax(axis=1)
    return np.asarray(across[longest] / np.sqrt(np.maximum(size[longest], 1e-300))[:, None])


def _thinned(xyz: Array, points: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return indices of about ``points`` points, spread evenly: the first of each small cube."""
    size = 0.008
    order = rng.permutation(len(xyz))
    while True:
        cube = np.floor(xyz[order] / size).astype(np.int64) + 2**19
        key = (cube[:, 0] << 40) | (cube[:, 1] << 20) | cube[:, 2]
        first = np.unique(key, return_index=True)[1]
        if len(first) <= points:
            return np.sort(order[first])
        size *= 1.15
