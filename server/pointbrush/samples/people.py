"""People: an articulated body of rounded cones, posed by hands, feet and eyes.

Arms and legs are bent so that hands and feet are at the places of the posture.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from pointbrush.samples.geometry import (
    UP,
    Array,
    Field,
    axis_angle,
    rigid,
    two_bones,
    unit,
    vec,
    yaw,
)
from pointbrush.samples.posture import Look, Posture
from pointbrush.samples.render import Solid, egg, rod
from pointbrush.samples.reproducible import inner, matmul
from pointbrush.samples.shapes import Cylinder
from pointbrush.samples.textures import Color, Material, cloth, face, linear, matte, noise, plain

UPPER_ARM = 0.29
FOREARM = 0.325
THIGH = 0.43
SHANK = 0.42
"""Metres between the joints of a person of scale 1."""


def arm(
    look: Look, posture: Posture, R: Array, chest: Array, s: float, label: int, which: int
) -> list[Solid]:
    """Upper arm, forearm and hand; ``which`` 0 left, 1 right."""
    side = 1.0 if which == 0 else -1.0
    skin = Material(partial(plain, color=linear(look.skin), grain=0.08), 0.75)
    shirt = look.shirt_material()
    shoulder = chest + matmul(R, vec(side * 0.182 * look.build, -0.055, -0.01) * s)
    hand = posture.hands[which]
    pole = matmul(R, posture.elbows * vec(side, 1, 1))
    elbow = two_bones(shoulder, hand, UPPER_ARM * s, FOREARM * s, pole)
    reach = elbow + unit(hand - elbow) * FOREARM * s
    wrist = elbow + (reach - elbow) * 0.78
    covered = look.sleeves
    hem = shoulder + (elbow - shoulder) * min(covered, 1.0)
    b = s * look.build
    parts = [rod(shoulder, hem, (0.062 * b, 0.052 * b), shirt, label, roughness=0.5)]
    if covered < 1:
        parts.append(rod(shoulder, elbow, (0.046 * b, 0.038 * b), skin, label))
    else:
        cuff = elbow + (wrist - elbow) * min(covered - 1, 1.0)
        parts.append(rod(elbow, cuff, (0.048 * b, 0.04 * b), shirt, label, roughness=0.5))
    parts.append(rod(elbow, wrist, (0.039 * b, 0.027 * b), skin, label, (0.9, None)))
    return parts + _hand(wrist, reach, R[:, 0], side, skin, label)


def _hand(
    wrist: Array, reach: Array, left: Array, side: float, skin: Material, label: int
) -> list[Solid]:
    """Return palm, thumb and four fingers, half closed round the held object."""
    forward = unit(reach - wrist)
    across = unit(left - inner(left, forward) * forward)
    down = np.cross(across, forward)
    down = down if down[1] < 0 else -down
    thumb = reach - across * (side * 0.042) + forward * 0.012 - down * 0.008
    parts = [
        rod(wrist, reach, (0.026, 0.036), skin, label, (0.62, across)),
        rod(reach - across * (side * 0.02) - forward * 0.03, thumb, (0.013, 0.0105), skin, label),
    ]
    for finger in range(4):
        aside, length = (finger - 1.5) * 0.0195, (0.032, 0.037, 0.035, 0.027)[finger]
        knuckle = reach + across * (side * aside) + forward * 0.02
        middle = knuckle + forward * length + down * 0.012
        tip = middle + forward * (0.25 * length) + down * length
        parts.append(rod(knuckle, middle, (0.0105, 0.0095), skin, label))
        parts.append(rod(middle, tip, (0.0095, 0.008), skin, label))
    return parts


def leg(look: Look, posture: Posture, hips: Array, s: float, label: int, which: int) -> list[Solid]:
    """Thigh, shank and shoe; ``which`` 0 left, 1 right."""
    side = 1.0 if which == 0 else -1.0
    foot = posture.feet[which]
    b = s * look.build
    trousers = Material(partial(cloth, color=linear(look.trousers), fold=0.16), 0.5)
    shoe = matte(look.shoes, infrared=0.5)
    sole = matte("#e8e6df" if look.shoes != "#e8e6df" else "#333333")
    hip = posture.pelvis + matmul(hips, vec(side * 0.088 * b, -0.03 * s, 0))
    toes = matmul(yaw(foot.heading), axis_angle(vec(1, 0, 0), foot.pitch))
    knee = two_bones(hip, foot.ankle, THIGH * s, SHANK * s, matmul(toes, vec(side * 0.12, 0, 1)))
    ankle = foot.ankle
    drop = 0.085 * s
    heel = ankle + matmul(toes, vec(0, -drop + 0.045, -0.035))
    ball = ankle + matmul(toes, vec(side * 0.012, -drop + 0.036, 0.14))
    tip = ankle + matmul(toes, vec(side * 0.008, -drop + 0.03, 0.19))
    across = toes[:, 0]
    return [
        rod(hip, knee, (0.092 * b, 0.066 * b), trousers, label, roughness=0.45),
        rod(
            knee,
            ankle + (knee - ankle) * 0.10,
            (0.064 * b, 0.056 * b),
            trousers,
            label,
            roughness=0.5,
        ),
        rod(ankle, heel, (0.04 * s, 0.043 * s), shoe, label),
        rod(heel, ball, (0.043, 0.036), shoe, label, (0.95, across)),
        rod(ankle, ball, (0.04, 0.03), shoe, label),
        rod(ball, tip, (0.036, 0.029), shoe, label, (0.95, across)),
        rod(
            heel - matmul(toes, vec(0, 0.025, 0)),
            tip - matmul(toes, vec(0, 0.012, 0)),
            (0.02, 0.018),
            sole,
            label,
            (2.0, toes[:, 1]),
        ),
    ]


def body(look: Look, posture: Posture, label: int) -> list[Solid]:
    """Return the solids of a person in a posture."""
    s = look.height / 1.75
    R = matmul(yaw(posture.facing + posture.twist), axis_angle(vec(1, 0, 0), posture.lean))
    R = matmul(R, axis_angle(vec(0, 0, 1), posture.side))
    hips = yaw(posture.facing + 0.4 * posture.twist)
    chest = posture.pelvis + matmul(R, vec(0, 0.50 * s, 0.0))
    return [
        *_torso(look, posture, R, hips, s, label),
        *_head(look, posture, R, chest, s, label),
        *arm(look, posture, R, chest, s, label, 0),
        *arm(look, posture, R, chest, s, label, 1),
        *leg(look, posture, hips, s, label, 0),
        *leg(look, posture, hips, s, label, 1),
    ]


def shadow_balls(posture: Posture) -> list[tuple[Array, float]]:
    """Return the balls that cast a body's shadow."""
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
        return np.asarray(p + matmul(R, vec(x, y, z) * s))

    belt = matte("#2a211b", infrared=0.3)
    parts = [
        rod(
            p - UP * 0.07 * s,
            at(0, 0.08, 0.0),
            (0.158 * build, 0.15 * build),
            trousers,
            label,
            (0.74, hips[:, 0]),
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
            (0.153 * build, 0.163 * build),
            shirt,
            label,
            (0.76, left),
            0.5,
        ),
        rod(
            at(0, 0.28, 0.0),
            at(0, 0.40, -0.005),
            (0.163 * build * full, 0.145 * build),
            shirt,
            label,
            (0.79, left),
            0.45,
        ),
        rod(
            at(-0.115, 0.445, -0.012),
            at(0.115, 0.445, -0.012),
            (0.064 * s, 0.064 * s),
            shirt,
            label,
            (1.0, R[:, 2]),
            0.3,
        ),
    ]
    for side in (-1, 1):
        inner, outer = at(side * 0.05, 0.50, -0.01), at(side * 0.17, 0.455, -0.01)
        parts.append(rod(inner, outer, (0.056 * s, 0.056 * s), shirt, label, (1.0, R[:, 2]), 0.3))
    return parts


def _head(
    look: Look, posture: Posture, R: Array, chest: Array, s: float, label: int
) -> list[Solid]:
    skin = Material(partial(plain, color=linear(look.skin), grain=0.08), 0.75)
    centre = chest + matmul(R, vec(0, 0.225 * s, 0.022 * s))
    turn = R
    if posture.gaze is not None:
        z = unit(0.55 * R[:, 2] + 0.45 * unit(posture.gaze - centre))
        x = unit(np.cross(UP, z))
        turn = np.column_stack([x, np.cross(z, x), z])
    hair = linear(look.hair)
    head = Material(partial(face, skin=linear(look.skin), hair=hair, hairline=0.075), 0.65)
    strand = Material(partial(_hair, color=hair), 0.35)

    def at(x: float, y: float, z: float) -> Array:
        return np.asarray(centre + matmul(turn, vec(x, y, z) * s))

    parts = [
        rod(
            chest + matmul(R, vec(0, 0.0, -0.012)),
            centre - matmul(turn, vec(0, 0.06, 0.018)),
            (0.058 * s, 0.054 * s),
            skin,
            label,
        ),
        egg(centre, (0.077 * s, 0.118 * s, 0.098 * s), head, label, turn),
        egg(at(0, -0.065, 0.035), (0.05 * s, 0.05 * s, 0.052 * s), skin, label, turn),
        egg(at(0, 0.035, -0.018), (0.084 * s, 0.096 * s, 0.092 * s), strand, label, turn, 0.5),
        rod(at(0, 0.012, 0.092), at(0, -0.022, 0.108), (0.009, 0.014), skin, label),
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
                (0.07 * s, 0.05 * s),
                strand,
                label,
                (0.7, turn[:, 0]),
                0.6,
            )
        )
    return parts


def _hair(p: Field, *, color: Color) -> Field:
    strands = p * np.array([[1], [0.2], [1]], np.float32)
    tone = 0.4 + 1.2 * noise(strands.astype(np.float32), 0.012, 2)
    return np.asarray(np.array(color, np.float32)[:, None] * tone, np.float32)
