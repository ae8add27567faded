"""People: an articulated body of rounded cones, posed by what the hands, feet and eyes do."""

from __future__ import annotations

from functools import partial

import numpy as np

from pointbrush.samples.geometry import UP, Array, Field, axis_angle, rigid, unit, vec, yaw
from pointbrush.samples.limbs import arm, leg
from pointbrush.samples.posture import Look, Posture
from pointbrush.samples.render import Solid
from pointbrush.samples.shapes import Cylinder
from pointbrush.samples.solids import egg, rod
from pointbrush.samples.textures import Color, Material, cloth, face, linear, matte, noise, plain


def body(look: Look, posture: Posture, label: int) -> list[Solid]:
    """Return the solids of a person in a posture."""
    s = look.height / 1.75
    R = yaw(posture.facing + posture.twist) @ axis_angle(vec(1, 0, 0), posture.lean)
    R = R @ axis_angle(vec(0, 0, 1), posture.side)
    hips = yaw(posture.facing + 0.4 * posture.twist)
    chest = posture.pelvis + R @ vec(0, 0.50 * s, 0.0)
    return [
        *_torso(look, posture, R, hips, s, label),
        *_head(look, posture, R, chest, s, label),
        *arm(look, posture, R, chest, s, label, 0),
        *arm(look, posture, R, chest, s, label, 1),
        *leg(look, posture, hips, s, label, 0),
        *leg(look, posture, hips, s, label, 1),
    ]


def shadow_balls(posture: Posture) -> list[tuple[Array, float]]:
    """Balls that stand for a body in shadows."""
    p = posture.pelvis
    balls = [
        (p + UP * 0.02, 0.17),
        (p + UP * 0.22, 0.17),
        (p + UP * 0.42, 0.18),
        (p + UP * 0.70, 0.11),
    ]
    for foot in posture.feet:
        knee = (foot.ankle + p) / 2
        balls += [
            (foot.ankle + UP * 0.02, 0.085),
            (knee, 0.085),
            ((knee + foot.ankle) / 2, 0.07),
            ((knee + p) / 2, 0.10),
        ]
    balls += [(hand, 0.06) for hand in posture.hands]
    return balls


def _torso(
    look: Look, posture: Posture, R: Array, hips: Array, s: float, label: int
) -> list[Solid]:
    shirt, build = look.shirt_material(), look.build * s
    trousers = Material(partial(cloth, color=linear(look.trousers), fold=0.16), 0.5)
    p, left = posture.pelvis, R[:, 0]
    full = 1 + 0.025 * posture.breath

    def at(x: float, y: float, z: float) -> Array:
        return np.asarray(p + R @ (vec(x, y, z) * s))

    belt = matte("#2a211b", infrared=0.3)
    parts = [
        rod(
            p - UP * 0.07 * s,
            at(0, 0.08, 0.0),
            0.158 * build,
            0.15 * build,
            trousers,
            label,
            0.74,
            hips[:, 0],
            0.35,
        ),
        Solid(
            Cylinder(),
            rigid(R, at(0, 0.085, 0.002)),
            belt,
            vec(0.156 * build, 0.018, 0.121 * build),
            label,
        ),
        rod(
            at(0, 0.09, 0.005),
            at(0, 0.30, 0.0),
            0.153 * build,
            0.163 * build,
            shirt,
            label,
            0.76,
            left,
            0.5,
        ),
        rod(
            at(0, 0.28, 0.0),
            at(0, 0.40, -0.005),
            0.163 * build * full,
            0.145 * build,
            shirt,
            label,
            0.79,
            left,
            0.45,
        ),
        rod(
            at(-0.115, 0.445, -0.012),
            at(0.115, 0.445, -0.012),
            0.064 * s,
            0.064 * s,
            shirt,
            label,
            1.0,
            R[:, 2],
            0.3,
        ),
    ]
    for side in (-1, 1):
        inner, outer = at(side * 0.05, 0.50, -0.01), at(side * 0.17, 0.455, -0.01)
        parts.append(rod(inner, outer, 0.056 * s, 0.056 * s, shirt, label, 1.0, R[:, 2], 0.3))
    return parts


def _head(
    look: Look, posture: Posture, R: Array, chest: Array, s: float, label: int
) -> list[Solid]:
    skin = Material(partial(plain, color=linear(look.skin), grain=0.08), 0.75)
    centre = chest + R @ vec(0, 0.225 * s, 0.022 * s)
    turn = R
    if posture.gaze is not None:
        z = unit(0.55 * R[:, 2] + 0.45 * unit(posture.gaze - centre))
        x = unit(np.cross(UP, z))
        turn = np.column_stack([x, np.cross(z, x), z])
    hair = linear(look.hair)
    head = Material(partial(face, skin=linear(look.skin), hair=hair, hairline=0.075), 0.65)
    strand = Material(partial(_hair, color=hair), 0.35)

    def at(x: float, y: float, z: float) -> Array:
        return np.asarray(centre + turn @ (vec(x, y, z) * s))

    parts = [
        rod(
            chest + R @ vec(0, 0.0, -0.012),
            centre - turn @ vec(0, 0.06, 0.018),
            0.058 * s,
            0.054 * s,
            skin,
            label,
        ),
        egg(centre, (0.077 * s, 0.118 * s, 0.098 * s), head, label, turn),
        egg(at(0, -0.065, 0.035), (0.05 * s, 0.05 * s, 0.052 * s), skin, label, turn),
        egg(at(0, 0.035, -0.018), (0.084 * s, 0.096 * s, 0.092 * s), strand, label, turn, 0.5),
        rod(at(0, 0.012, 0.092), at(0, -0.022, 0.108), 0.009, 0.014, skin, label),
    ]
    parts += [
        egg(at(side * 0.079, -0.005, 0.0), (0.012, 0.03, 0.02), skin, label, turn)
        for side in (-1, 1)
    ]
    if look.long_hair:
        parts.append(
            rod(
                at(0, 0.02, -0.06),
                at(0, -0.17, -0.075),
                0.07 * s,
                0.05 * s,
                strand,
                label,
                0.7,
                turn[:, 0],
                0.6,
            )
        )
    return parts


def _hair(p: Field, *, color: Color) -> Field:
    strands = p * np.array([[1], [0.2], [1]], np.float32)
    tone = 0.4 + 1.2 * noise(strands.astype(np.float32), 0.012, 2)
    return np.asarray(np.array(color, np.float32)[:, None] * tone, np.float32)
