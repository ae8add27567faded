"""Small recordings with exact truth for the tracking tests: ray-cast capsules and boxes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation


@dataclass(eq=False)
class Frame:
    """A TrackFrame in memory, with its truth."""

    xyz: np.ndarray
    rgb: np.ndarray | None = None
    truth: np.ndarray | None = None
    intensity: np.ndarray | None = None
    viewpoint: np.ndarray | None = None
    pose: np.ndarray | None = None

    @cached_property
    def kdtree(self) -> cKDTree:
        return cKDTree(self.xyz, balanced_tree=False)


@dataclass
class Part:
    """A capsule from a to b with radii, or a box (centre, half size, rotation)."""

    label: int
    colour: tuple[float, float, float]
    a: np.ndarray
    b: np.ndarray
    ra: float = 0.0
    rb: float = 0.0
    rot: np.ndarray | None = None  # a box when given: a centre, b half size
    stripe: float = 0.0


@dataclass
class Sensor:
    width: int = 256
    height: int = 212
    focal: float = 183.0
    origin: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.5, 0.0]))
    look: np.ndarray = field(default_factory=lambda: np.eye(3))  # columns: right, up, forward
    spherical: bool = False
    noise: float = 0.0012

    @cached_property
    def rays(self) -> np.ndarray:
        v, u = np.mgrid[0 : self.height, 0 : self.width]
        if self.spherical:
            az = (u + 0.5) / self.width * 2 * np.pi
            el = np.radians(np.linspace(8, -24, self.height))[v]
            d = np.stack([np.cos(el) * np.sin(az), np.sin(el), np.cos(el) * np.cos(az)], -1)
        else:
            d = np.stack(
                [
                    (u - self.width / 2 + 0.5) / self.focal,
                    -(v - self.height / 2 + 0.5) / self.focal,
                    np.ones(u.shape),
                ],
                -1,
            )
            d /= np.linalg.norm(d, axis=-1, keepdims=True)
        return d.reshape(-1, 3)


def _capsule(d: np.ndarray, pa: np.ndarray, pb: np.ndarray, ra: float, rb: float):
    """Rounded cone, Inigo Quilez's formula; ray origin at 0; returns t (inf), normals."""
    ba, oa, ob = pb - pa, -pa, -pb
    rr = ra - rb
    m0, m1, m2 = ba @ ba, ba @ oa, d @ ba
    m3, m5 = d @ oa, oa @ oa
    m6, m7 = d @ ob, ob @ ob
    d2 = m0 - rr * rr
    k2 = d2 - m2 * m2
    k1 = d2 * m3 - m1 * m2 + m2 * rr * ra
    k0 = d2 * m5 - m1 * m1 + m1 * rr * ra * 2 - m0 * ra * ra
    h = k1 * k1 - k0 * k2
    k2 = np.where(np.abs(k2) < 1e-12, 1e-12, k2)
    t = (-np.sqrt(np.maximum(h, 0)) - k1) / k2
    y = m1 - ra * rr + t * m2
    hit = (h >= 0) & (y > 0) & (y < d2)
    t = np.where(hit, t, np.inf)
    n = np.where(hit[:, None], (oa + t[:, None].clip(-1e6, 1e6) * d) * d2 - ba * y[:, None], 0)
    for mb, mc, r, o in ((m3, m5, ra, oa), (m6, m7, rb, ob)):
        hh = mb * mb - mc + r * r
        ts = np.where(hh > 0, -mb - np.sqrt(np.maximum(hh, 0)), np.inf)
        better = (ts < t) & (ts > 0) & ~hit
        t = np.where(better, ts, t)
        n = np.where(better[:, None], o + np.where(better, ts, 0)[:, None] * d, n)
    n /= np.linalg.norm(n, axis=1, keepdims=True) + 1e-12
    return np.where(t > 0.05, t, np.inf), n


def _box(d: np.ndarray, c: np.ndarray, half: np.ndarray, rot: np.ndarray):
    dl, ol = d @ rot, -c @ rot
    dl = np.where(np.abs(dl) < 1e-9, 1e-9, dl)
    t1, t2 = (-half - ol) / dl, (half - ol) / dl
    near, far = np.minimum(t1, t2), np.maximum(t1, t2)
    axis = np.argmax(near, 1)
    t = near.max(1)
    ok = (t < far.min(1)) & (t > 0.05)
    n = np.zeros_like(d)
    n[np.arange(len(d)), axis] = -np.sign(dl[np.arange(len(d)), axis])
    return np.where(ok, t, np.inf), n @ rot.T


def _part(part: Part, d: np.ndarray, origin: np.ndarray):
    if part.rot is not None:
        return _box(d, part.a - origin, part.b, part.rot)
    return _capsule(d, part.a - origin, part.b - origin, part.ra, part.rb)


def _extent(part: Part):
    if part.rot is not None:
        return part.a, float(np.linalg.norm(part.b))
    return (part.a + part.b) / 2, float(np.linalg.norm(part.b - part.a) / 2) + max(part.ra, part.rb)


class Camera:
    def __init__(self, sensor: Sensor, static: list[Part]) -> None:
        self.s = sensor
        self.static = static
        self._base = None
        self._key = None

    def _cast(self, parts, t, label, colour, normal, d):
        s = self.s
        for part in parts:
            c, r = _extent(part)
            v = (c - s.origin) @ s.look
            dist = np.linalg.norm(v)
            idx = None
            if dist > r * 1.05:
                ang = np.arcsin(min(1, r / dist))
                if s.spherical:
                    unit = (c - s.origin) / dist
                    idx = np.flatnonzero(d @ unit > np.cos(ang))
                elif v[2] > r * 1.05:
                    u0 = v[0] / v[2] * s.focal + s.width / 2
                    v0 = -v[1] / v[2] * s.focal + s.height / 2
                    rad = r / (v[2] - r) * s.focal * 1.2 + 3
                    x0, x1 = int(max(0, u0 - rad)), int(min(s.width, u0 + rad + 1))
                    y0, y1 = int(max(0, v0 - rad)), int(min(s.height, v0 + rad + 1))
                    if x0 >= x1 or y0 >= y1:
                        continue
                    idx = (np.arange(y0, y1)[:, None] * s.width + np.arange(x0, x1)).ravel()
                elif v[2] < -r:
                    continue
            if idx is None:
                idx = np.arange(len(d))
            if not len(idx):
                continue
            tt, n = _part(part, d[idx], s.origin)
            near = tt < t[idx]
            k = idx[near]
            t[k] = tt[near]
            label[k] = part.label
            col = np.tile(np.array(part.colour, np.float64), (len(k), 1))
            p = s.origin + d[k] * tt[near][:, None]
            if part.stripe:
                axis = part.b - part.a if part.rot is None else part.rot[:, 1]
                w = ((p - part.a) @ axis) / (axis @ axis) * (1 if part.rot is None else 4)
                col[np.floor(w * part.stripe).astype(int) % 2 == 1] *= 0.35
            colour[k] = col
            normal[k] = n[near]

    def shoot(self, parts: list[Part], rng: np.random.Generator) -> Frame:
        s = self.s
        d = s.rays @ s.look.T
        n = len(d)
        key = (s.origin.tobytes(), s.look.tobytes())
        if self._key != key:
            base = (np.full(n, np.inf), np.zeros(n, np.uint16), np.zeros((n, 3)), np.zeros((n, 3)))
            self._cast(self.static, *base, d)
            self._base, self._key = base, key
        t, label, colour, normal = (a.copy() for a in self._base)
        self._cast(parts, t, label, colour, normal, d)
        light = np.array([0.3, 0.8, -0.5]) / np.linalg.norm([0.3, 0.8, -0.5])
        shade = 0.55 + 0.45 * np.abs(normal @ light)
        rgb = np.clip(colour * shade[:, None] + rng.normal(0, 4, (n, 3)), 0, 255).astype(np.uint8)
        cos = np.abs((normal * d).sum(1)).clip(0.05)
        z = t.copy()
        z[~np.isfinite(z)] = 0
        if s.spherical:
            t = t + rng.normal(0, 0.015, n)
            ok = np.isfinite(t) & (t < 90) & (rng.random(n) > 0.05)
        else:
            t = t + rng.normal(0, 1, n) * s.noise * (0.6 + 0.35 * z**2)
            far = ~np.isfinite(t)
            t[far] = 99.0
            img = t.reshape(s.height, s.width)
            jump = np.zeros_like(img, bool)
            jump[:, 1:] |= np.abs(img[:, 1:] - img[:, :-1]) > 0.08
            fly = jump & (rng.random(img.shape) < 0.35)
            img[:, 1:][fly[:, 1:]] += (
                rng.random(int(fly[:, 1:].sum())) * (img[:, :-1] - img[:, 1:])[fly[:, 1:]]
            )
            t = img.ravel()
            ok = np.isfinite(t) & (t < 8) & (rng.random(n) > 0.02) & ~(cos < 0.12)
            ok &= ~(jump.ravel() & (rng.random(n) < 0.3))
        xyz = s.origin + d * np.where(ok, t, 0)[:, None]
        order = rng.permutation(np.flatnonzero(ok))
        return Frame(
            xyz[order].astype(np.float32),
            rgb[order],
            label[order],
            None,
            s.origin.astype(np.float64),
        )


def room() -> list[Part]:
    e = np.eye(3)
    return [
        Part(0, (120, 105, 90), np.array([0, -0.05, 3.0]), np.array([4, 0.05, 4]), rot=e, stripe=3),
        Part(0, (190, 190, 180), np.array([0, 1.5, 5.5]), np.array([4, 2, 0.05]), rot=e),
        Part(0, (180, 190, 200), np.array([-2.6, 1.5, 3]), np.array([0.05, 2, 4]), rot=e),
        Part(
            0, (110, 70, 40), np.array([1.9, 0.4, 4.6]), np.array([0.5, 0.4, 0.4]), rot=e, stripe=2
        ),
        Part(0, (60, 80, 60), np.array([-1.9, 0.9, 5.1]), np.array([0.3, 0.9, 0.3]), rot=e),
    ]


def person(label, at, heading, phase, tint, arms=None) -> list[Part]:
    """Feet at ``at``; ``phase`` swings legs; ``arms`` two hand positions or None (swing)."""
    f = np.array([np.sin(heading), 0, np.cos(heading)])
    r = np.array([f[2], 0, -f[0]])
    up = np.array([0, 1.0, 0])
    hip, neck = at + 0.92 * up, at + 1.45 * up
    skin = (205, 160, 130)
    trousers = tuple(0.5 * c for c in tint[::-1])
    parts = [
        Part(label, tint, hip + 0.08 * up, neck - 0.08 * up, 0.15, 0.17),
        Part(label, skin, neck + 0.16 * up, neck + 0.22 * up, 0.1, 0.1),
    ]
    for side in (-1, 1):
        sw = side * np.sin(phase) * 0.45
        knee = hip + r * 0.1 * side + f * np.sin(sw) * 0.45 - up * np.cos(sw) * 0.45
        bend = sw - 0.5 * max(0, np.sin(phase * 1 + (0 if side > 0 else np.pi) + 1))
        foot = knee + f * np.sin(bend) * 0.42 - up * np.cos(bend) * 0.42
        parts.append(Part(label, trousers, hip + r * 0.1 * side, knee, 0.085, 0.06))
        parts.append(Part(label, trousers, knee, foot, 0.06, 0.045))
        parts.append(Part(label, (40, 40, 40), foot, foot + f * 0.14 - up * 0.02, 0.045, 0.04))
        shoulder = neck - 0.06 * up + r * 0.22 * side
        if arms is None:
            elbow = shoulder - up * 0.28 - f * np.sin(sw) * 0.14
            hand = elbow - up * 0.2 + f * (-np.sin(sw) * 0.2 + 0.08)
        else:
            hand = arms[(side + 1) // 2]
            mid = (shoulder + hand) / 2
            v = hand - shoulder
            length = np.linalg.norm(v)
            if length > 0.56:
                hand = shoulder + v / length * 0.56
                mid = (shoulder + hand) / 2
                length = 0.56
            bend_d = np.sqrt(max(0.29**2 - (length / 2) ** 2, 0.0))
            elbow = mid + bend_d * (r * side * 0.6 - up * 0.8)
        parts.append(Part(label, tint, shoulder, elbow, 0.055, 0.045))
        parts.append(Part(label, skin, elbow, hand, 0.042, 0.035))
        parts.append(Part(label, skin, hand, hand + 0.03 * f, 0.045, 0.04))
    return parts


def pin(label, centre, rot, tint) -> list[Part]:
    ax = rot @ np.array([0, 1.0, 0])
    p = lambda h: centre + ax * h  # noqa: E731
    return [
        Part(label, (235, 235, 230), p(-0.26), p(-0.02), 0.013, 0.02),
        Part(label, tint, p(0.0), p(0.1), 0.028, 0.045, stripe=1.0),
        Part(label, tint, p(0.1), p(0.22), 0.045, 0.028),
    ]


def juggling(seed=0, frames=60, pins=3, sensor=None, people=None) -> list[Frame]:
    rng = np.random.default_rng(seed)
    cam = Camera(sensor or Sensor(), room())
    people = people or (1 if pins == 3 else 2)
    tints = [tuple(rng.integers(40, 230, 3)) for _ in range(2)]
    alike = tints[0] if seed % 2 else (220, 60, 40)
    places = (
        [np.array([0.1, 0, 2.4])]
        if people == 1
        else [
            np.array([-1.1, 0, 2.7]),
            np.array([1.1, 0, 2.7]),
        ]
    )
    heads = [np.pi] if people == 1 else [np.pi / 2 + 0.35, -np.pi / 2 - 0.35]

    def hand(person_i, side, time, shift):
        h = heads[person_i]
        f = np.array([np.sin(h), 0, np.cos(h)])
        r = np.array([f[2], 0, -f[0]])
        ph = 2 * np.pi * (time / 0.9 + shift + (0.5 if side else 0))
        return (
            places[person_i]
            + np.array([0, 1.02 + 0.09 * np.sin(ph), 0])
            + f * (0.36 + 0.06 * np.cos(ph * 1))
            + r * (0.3 if side else -0.3)
            + r * 0.09 * np.cos(ph)
        )

    # each pin: sequence of holds and flights
    flight, dwell = 0.75, 0.33
    paths = []
    for k in range(pins):
        hands_n = 2 * people
        t = -rng.random() * 0.2 - k * (flight + dwell) / pins
        at = k % hands_n
        events = []
        turn = 0.0
        while t < frames / 30 + 2:
            cross = (at + 1) % 2 + 2 * (at // 2)
            to = cross if people == 1 or rng.random() < 0.4 else (at + 2) % 4
            fl = flight * (1.25 if people == 2 and to // 2 != at // 2 else 1.0)
            spins = 1 if rng.random() < 0.75 else 2
            events.append((t, t + dwell, t + dwell + fl, at, to, turn, spins))
            turn += 2 * np.pi * spins
            t += dwell + fl
            at = to
        paths.append(events)
    colours = [alike if seed % 2 else tuple(rng.integers(30, 240, 3)) for _ in range(pins)]
    out = []
    shift = rng.random(2)
    for i in range(frames):
        time = i / 30
        parts: list[Part] = []
        for k, events in enumerate(paths):
            e = next(e for e in events if e[0] <= time < e[2] or e is events[-1])
            t0, t1, t2, a, b, turn, spins = e
            hp = lambda idx, tt: hand(idx // 2, idx % 2, tt, shift[idx // 2])  # noqa: E731
            if time < t1:
                c = hp(a, time)
                ang = turn + 0.4 * np.sin((time - t0) / (t1 - t0) * np.pi)
                lift = np.array([0, 0.06, 0])
            else:
                s = (time - t1) / (t2 - t1)
                p0, p1 = hp(a, t1), hp(b, t2)
                T = t2 - t1
                v0 = (p1 - p0) / T
                v0[1] += 0.5 * 9.81 * T
                dt = time - t1
                c = p0 + v0 * dt
                c[1] -= 0.5 * 9.81 * dt * dt
                ang = turn + 2 * np.pi * spins * s
                lift = np.array([0, 0.06, 0])
            h = heads[a // 2]
            r = np.array([np.cos(h), 0, -np.sin(h)])
            base = Rotation.from_rotvec(0.9 * r) if True else None
            rot = (Rotation.from_rotvec(-ang * r) * base).as_matrix()
            parts += pin(k + 1, c + lift + rot @ np.array([0, 0.14, 0]), rot, colours[k])
        for j in range(people):
            arms = [hand(j, side, time, shift[j]) for side in (0, 1)]
            sway = np.array([0.02 * np.sin(time * 2 + j), 0, 0.02 * np.cos(time * 1.7)])
            parts += person(0, places[j] + sway, heads[j], 0.2 * np.sin(time), tints[j], arms)
        out.append(cam.shoot(parts, rng))
    return out


def walking(seed=0, frames=60, people=3, sensor=None, rate=30.0) -> list[Frame]:
    rng = np.random.default_rng(seed)
    cam = Camera(sensor or Sensor(), room())
    starts = [
        np.array([rng.uniform(-1.2, 1.2), 0, 2.2 + 0.75 * k + rng.uniform(-0.1, 0.1)])
        for k in range(people)
    ]
    tints = [tuple(rng.integers(40, 220, 3)) for _ in range(people)]
    speed = rng.uniform(0.7, 1.3, people) * np.where(rng.random(people) < 0.5, -1, 1)
    off = rng.random(people) * 6
    out = []
    for i in range(frames):
        time = i / rate
        parts: list[Part] = []
        for k in range(people):
            span = 1.5
            s = (starts[k][0] + speed[k] * time + span) % (4 * span)
            x = s - span if s < 2 * span else 3 * span - s
            head = (np.pi / 2) * np.sign(speed[k]) * (1 if s < 2 * span else -1)
            wob = 0.25 * np.sin(0.6 * time + off[k])
            at = np.array([x, 0, starts[k][2] + wob])
            parts += person(
                k + 1, at, head, off[k] + 2 * np.pi * abs(speed[k]) * time * 0.75, tints[k]
            )
        out.append(cam.shoot(parts, rng))
    return out


def passing(frames=14) -> list[Frame]:
    """Person 1 walks by close to the sensor, and for a while hides person 2, who stands behind."""
    rng = np.random.default_rng(4)
    cam = Camera(Sensor(192, 168, 130.0, origin=np.array([0.0, 1.0, 0.0])), room())
    tints = [(60, 110, 200), (190, 80, 60)]
    out = []
    for i in range(frames):
        t = i / (frames - 1)
        near, far = np.array([1.2 * t - 0.6, 0, 1.6]), np.array([0.19 - 0.38 * t, 0, 2.8])
        parts = person(1, near, np.pi / 2, 6.0 * t, tints[0])
        parts += person(2, far, -np.pi / 2, 6.0 * t + 1, tints[1])
        out.append(cam.shoot(parts, rng))
    return out


def carried(frames=10, hold=None) -> list[Frame]:
    """Person 1 walks, person 2 stands, before a camera that somebody carries, 5 frames a second.

    In the camera's coordinates (right, up, ahead), with its poses.  ``hold``: frame number →
    rotation vector (3,) and place (3,) of the camera.
    """
    rng = np.random.default_rng(5)
    sensor = Sensor(192, 168, 130.0)
    cam = Camera(sensor, room())
    out = []
    for i in range(frames):
        turn, at = (hold or _walks)(i)
        sensor.look, sensor.origin = Rotation.from_rotvec(turn).as_matrix(), at
        parts = person(1, np.array([0.9 - 0.2 * i, 0, 3.2]), -np.pi / 2, 1.2 * i, (60, 110, 200))
        parts += person(2, np.array([0.9, 0, 2.6]), np.pi, 0.1 * i, (190, 80, 60))
        frame = cam.shoot(parts, rng)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = sensor.look, at
        xyz = ((frame.xyz - at) @ sensor.look).astype(np.float32)
        out.append(Frame(xyz, frame.rgb, frame.truth, pose=pose))
    return out


def _walks(i: int) -> tuple[np.ndarray, np.ndarray]:
    return np.array([0.02, 0.3 - 0.05 * i, 0.0]), np.array([0.12 * i - 0.5, 1.4, -0.05 * i])


def swaying(frames=10, far=0.015, turn=0.015) -> list[Frame]:
    """The same before a camera in a hand that is held still: by so many metres, and radians."""
    axes = np.array([[1.0, 0.7, -0.5], [0.4, -1.0, 0.8]])

    def hold(i: int) -> tuple[np.ndarray, np.ndarray]:
        to, fro = np.sin(1.3 * i), np.sin(2.1 * i)
        return turn * (to * axes[0] + fro * axes[1]), np.array([0, 1.4, 0]) + far * fro * axes[0]

    return carried(frames, hold)


def tabletop(seed=0, frames=60, sensor=None) -> list[Frame]:
    rng = np.random.default_rng(seed)
    e = np.eye(3)
    table = [Part(0, (150, 110, 70), np.array([0, 0.72, 1.5]), np.array([0.8, 0.02, 0.4]), rot=e)]
    s = sensor or Sensor()
    tilt = Rotation.from_euler("x", 25, degrees=True).as_matrix()
    s.look = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]]) @ tilt
    cam = Camera(s, room() + table)
    objs = []
    for k in range(4):
        c = np.array([-0.42 + 0.28 * k, 0.0, 1.45 + rng.uniform(-0.12, 0.12)])
        colour = tuple(rng.integers(30, 230, 3)) if k else (150, 112, 72)
        objs.append((k % 3, c, colour, rng.uniform(0, 3)))
    pos = [o[1].copy() for o in objs]
    ang = [o[3] for o in objs]
    lift = [0.0] * 4
    out = []
    plan = rng.permutation(4)
    for i in range(frames):
        step = 24
        k = int(plan[(i // step) % 4])
        ph = (i % step) / step
        goal_dir = np.array([1 if pos[k][0] < 0 else -1, 0, 0.3 * np.sin(k)]) * 0.006
        hand = None
        lifted = k % 2 == 1
        if 0.2 < ph < 0.85:
            pos[k] = pos[k] + goal_dir * (0.4 if not lifted else 1.0)
            ang[k] += 0.02
            lift[k] = 0.14 * np.sin((ph - 0.2) / 0.65 * np.pi) if lifted else 0.0
            hand = True
        else:
            lift[k] = 0.0
        parts = []
        for j, (shape, _, colour, _) in enumerate(objs):
            rot = Rotation.from_euler("y", ang[j]).as_matrix()
            base = pos[j] + np.array([0, 0.74 + lift[j], 0])
            if shape == 0:
                half = np.array([0.07, 0.06, 0.05])
                parts.append(Part(j + 1, colour, base + [0, 0.06, 0], half, rot=rot, stripe=1.0))
            elif shape == 1:
                parts.append(
                    Part(j + 1, colour, base + [0, 0.06, 0], base + [0, 0.061, 0], 0.06, 0.06)
                )
            else:
                parts.append(
                    Part(
                        j + 1,
                        colour,
                        base + [0, 0.04, 0],
                        base + [0, 0.14, 0],
                        0.04,
                        0.035,
                        stripe=3,
                    )
                )
        away = 1 - np.clip(min(ph, 1 - ph) * 6, 0, 1)
        if hand or away < 1:
            tip = pos[k] + np.array([0.05, 0.74 + lift[k] + 0.12 + away * 0.25, 0.06])
            parts.append(Part(0, (205, 160, 130), tip, tip + [0.04, 0.05, 0.08], 0.035, 0.04))
            parts.append(
                Part(
                    0, (60, 70, 120), tip + [0.04, 0.05, 0.08], tip + [0.25, 0.35, 0.4], 0.045, 0.06
                )
            )
        out.append(cam.shoot(parts, rng))
    return out


def _meet(one, other, seconds) -> bool:
    """Whether two cars, each of lane, speed and place in it, are ever less than 5 m apart."""
    gaps = [one[2] - other[2] + t * (one[1] - other[1]) for t in (0.0, seconds)]
    return one[0] == other[0] and (min(np.abs(gaps)) < 5.0 or gaps[0] * gaps[1] < 0)


def street(seed=0, frames=20, ego=True, rate=10.0) -> list[Frame]:
    """A spinning 48-beam lidar between parked and driving cars, walkers, houses."""
    rng = np.random.default_rng(seed)
    e = np.eye(3)
    static = [Part(0, (90, 90, 90), np.array([0, -0.1, 40.0]), np.array([60, 0.1, 120]), rot=e)]
    for k in range(14):
        side = -1 if k % 2 else 1
        static.append(
            Part(
                0,
                (150, 120, 100),
                np.array([side * rng.uniform(11, 14), 4, -20 + 9.0 * (k // 2)]),
                np.array([3, 4, 4.0]),
                rot=e,
            )
        )
        static.append(
            Part(
                0,
                (60, 90, 50),
                np.array([side * 8.0, 0, -18 + 9.0 * (k // 2)]),
                np.array([side * 8.0, 3, -18 + 9.0 * (k // 2)]),
                0.15,
                0.12,
            )
        )
    cars = []
    while len(cars) < 7:
        k = len(cars) % 3
        car = [-2.0, 2.0, 5.5][k], rng.uniform(0.8, 1.2) * [9.0, -8.0, 0.0][k], rng.uniform(-12, 30)
        if not any(_meet(car, other, frames / rate) for other in cars):
            cars.append(car)
    walkers = [(rng.uniform(-7, 7), rng.uniform(4, 20), rng.uniform(-1.4, 1.4)) for _ in range(4)]
    out = []
    for i in range(frames):
        time = i / rate
        ego_z = 8.0 * time if ego else 0.0
        parts = []
        for k, (x, v, z) in enumerate(cars):
            c = np.array([x, 0.55, z + v * time])
            parts.append(Part(k + 1, (120, 40, 40), c, np.array([0.9, 0.4, 2.1]), rot=e))
            parts.append(
                Part(k + 1, (120, 40, 40), c + [0, 0.65, -0.2], np.array([0.75, 0.3, 1.1]), rot=e)
            )
        for k, (x, z, v) in enumerate(walkers):
            parts += person(
                20 + k,
                np.array([x + v * time, 0, z]),
                np.pi / 2 * np.sign(v),
                8 * time,
                (90, 90, 200),
            )
        s = Sensor(900, 48, spherical=True, origin=np.array([0, 1.9, ego_z]))
        f = Camera(s, static).shoot(parts, rng)
        pose = np.eye(4)
        pose[:3, 3] = s.origin
        out.append(
            Frame(
                (f.xyz - s.origin).astype(np.float32),
                None,
                f.truth,
                rng.random(len(f.xyz)).astype(np.float32),
                np.zeros(3),
                pose if ego else None,
            )
        )
    return out


KINDS: dict[str, Callable[..., list[Frame]]] = {
    "juggling": juggling,
    "tabletop": tabletop,
    "walking": walking,
    "street": street,
}
