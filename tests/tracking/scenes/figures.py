"""What the scenes are made of: a room, and people of capsules."""

from __future__ import annotations

import numpy as np

from scenes.raycaster import Part


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


UP = np.array([0, 1.0, 0])
SKIN = (205, 160, 130)


def person(label, at, heading, phase, tint, arms=None) -> list[Part]:
    """Feet at ``at``; ``phase`` swings legs; ``arms`` two hand positions or None (swing)."""
    ahead = np.array([np.sin(heading), 0, np.cos(heading)])
    right = np.array([ahead[2], 0, -ahead[0]])
    hip, neck = at + 0.92 * UP, at + 1.45 * UP
    parts = [
        Part(label, tint, hip + 0.08 * UP, neck - 0.08 * UP, 0.15, 0.17),
        Part(label, SKIN, neck + 0.16 * UP, neck + 0.22 * UP, 0.1, 0.1),
    ]
    for side in (-1, 1):
        swing = side * np.sin(phase) * 0.45
        bend = swing - 0.5 * max(0, np.sin(phase * 1 + (0 if side > 0 else np.pi) + 1))
        knee = hip + right * 0.1 * side + ahead * np.sin(swing) * 0.45 - UP * np.cos(swing) * 0.45
        foot = knee + ahead * np.sin(bend) * 0.42 - UP * np.cos(bend) * 0.42
        trousers = tuple(0.5 * c for c in tint[::-1])
        parts.append(Part(label, trousers, hip + right * 0.1 * side, knee, 0.085, 0.06))
        parts.append(Part(label, trousers, knee, foot, 0.06, 0.045))
        parts.append(Part(label, (40, 40, 40), foot, foot + ahead * 0.14 - UP * 0.02, 0.045, 0.04))
        shoulder = neck - 0.06 * UP + right * 0.22 * side
        if arms is None:
            elbow = shoulder - UP * 0.28 - ahead * np.sin(swing) * 0.14
            hand = elbow - UP * 0.2 + ahead * (-np.sin(swing) * 0.2 + 0.08)
        else:
            hand, elbow = _reach(shoulder, arms[(side + 1) // 2], right * side * 0.6 - UP * 0.8)
        parts.append(Part(label, tint, shoulder, elbow, 0.055, 0.045))
        parts.append(Part(label, SKIN, elbow, hand, 0.042, 0.035))
        parts.append(Part(label, SKIN, hand, hand + 0.03 * ahead, 0.045, 0.04))
    return parts


def _reach(shoulder, hand, outward) -> tuple[np.ndarray, np.ndarray]:
    """Hand, as far as the arm goes, and elbow, bent ``outward``."""
    middle, way = (shoulder + hand) / 2, hand - shoulder
    length = np.linalg.norm(way)
    if length > 0.56:
        hand = shoulder + way / length * 0.56
        middle, length = (shoulder + hand) / 2, 0.56
    return hand, middle + np.sqrt(max(0.29**2 - (length / 2) ** 2, 0.0)) * outward
