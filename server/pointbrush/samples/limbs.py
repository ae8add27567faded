"""Arms and legs, bent so that hands and feet are where the posture wants them."""

from __future__ import annotations

from functools import partial

import numpy as np

from pointbrush.samples.geometry import Array, axis_angle, two_bones, unit, vec, yaw
from pointbrush.samples.posture import Look, Posture
from pointbrush.samples.render import Solid
from pointbrush.samples.solids import rod
from pointbrush.samples.textures import Material, cloth, linear, matte, plain

UPPER_ARM, FOREARM, THIGH, SHANK = 0.29, 0.325, 0.43, 0.42


def arm(
    look: Look, posture: Posture, R: Array, chest: Array, s: float, label: int, which: int
) -> list[Solid]:
    """Upper arm, forearm and hand; ``which`` 0 left, 1 right."""
    side = 1.0 if which == 0 else -1.0
    skin = Material(partial(plain, color=linear(look.skin), grain=0.08), 0.75)
    shirt = look.shirt_material()
    shoulder = chest + R @ (vec(side * 0.182 * look.build, -0.055, -0.01) * s)
    hand = posture.hands[which]
    pole = R @ (posture.elbows * vec(side, 1, 1))
    elbow = two_bones(shoulder, hand, UPPER_ARM * s, FOREARM * s, pole)
    reach = elbow + unit(hand - elbow) * FOREARM * s
    wrist = elbow + (reach - elbow) * 0.78
    covered = look.sleeves
    hem = shoulder + (elbow - shoulder) * min(covered, 1.0)
    b = s * look.build
    parts = [rod(shoulder, hem, 0.062 * b, 0.052 * b, shirt, label, roughness=0.5)]
    if covered < 1:
        parts.append(rod(shoulder, elbow, 0.046 * b, 0.038 * b, skin, label))
    else:
        cuff = elbow + (wrist - elbow) * min(covered - 1, 1.0)
        parts.append(rod(elbow, cuff, 0.048 * b, 0.04 * b, shirt, label, roughness=0.5))
    parts.append(rod(elbow, wrist, 0.039 * b, 0.027 * b, skin, label, 0.9))
    return parts + _hand(wrist, reach, R[:, 0], side, skin, label)


def _hand(
    wrist: Array, reach: Array, left: Array, side: float, skin: Material, label: int
) -> list[Solid]:
    """Palm, thumb and four fingers, half closed round what the hand holds."""
    forward = unit(reach - wrist)
    across = unit(left - (left @ forward) * forward)
    down = np.cross(across, forward)
    down = down if down[1] < 0 else -down
    thumb = reach - across * (side * 0.042) + forward * 0.012 - down * 0.008
    parts = [
        rod(wrist, reach, 0.026, 0.036, skin, label, 0.62, across),
        rod(reach - across * (side * 0.02) - forward * 0.03, thumb, 0.013, 0.0105, skin, label),
    ]
    for finger in range(4):
        aside, length = (finger - 1.5) * 0.0195, (0.032, 0.037, 0.035, 0.027)[finger]
        knuckle = reach + across * (side * aside) + forward * 0.02
        middle = knuckle + forward * length + down * 0.012
        tip = middle + forward * (0.25 * length) + down * length
        parts.append(rod(knuckle, middle, 0.0105, 0.0095, skin, label))
        parts.append(rod(middle, tip, 0.0095, 0.008, skin, label))
    return parts


def leg(look: Look, posture: Posture, hips: Array, s: float, label: int, which: int) -> list[Solid]:
    """Thigh, shank and shoe; ``which`` 0 left, 1 right."""
    side = 1.0 if which == 0 else -1.0
    foot = posture.feet[which]
    b = s * look.build
    trousers = Material(partial(cloth, color=linear(look.trousers), fold=0.16), 0.5)
    shoe = matte(look.shoes, infrared=0.5)
    sole = matte("#e8e6df" if look.shoes != "#e8e6df" else "#333333")
    hip = posture.pelvis + hips @ vec(side * 0.088 * b, -0.03 * s, 0)
    toes = yaw(foot.heading) @ axis_angle(vec(1, 0, 0), foot.pitch)
    knee = two_bones(hip, foot.ankle, THIGH * s, SHANK * s, toes @ vec(side * 0.12, 0, 1))
    ankle = foot.ankle
    drop = 0.085 * s
    heel = ankle + toes @ vec(0, -drop + 0.045, -0.035)
    ball = ankle + toes @ vec(side * 0.012, -drop + 0.036, 0.14)
    tip = ankle + toes @ vec(side * 0.008, -drop + 0.03, 0.19)
    across = toes[:, 0]
    return [
        rod(hip, knee, 0.092 * b, 0.066 * b, trousers, label, roughness=0.45),
        rod(
            knee,
            ankle + (knee - ankle) * 0.10,
            0.064 * b,
            0.056 * b,
            trousers,
            label,
            roughness=0.5,
        ),
        rod(ankle, heel, 0.04 * s, 0.043 * s, shoe, label),
        rod(heel, ball, 0.043, 0.036, shoe, label, 0.95, across),
        rod(ankle, ball, 0.04, 0.03, shoe, label),
        rod(ball, tip, 0.036, 0.029, shoe, label, 0.95, across),
        rod(
            heel - toes @ vec(0, 0.025, 0),
            tip - toes @ vec(0, 0.012, 0),
            0.02,
            0.018,
            sole,
            label,
            2.0,
            toes[:, 1],
        ),
    ]
