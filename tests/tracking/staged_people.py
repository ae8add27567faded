"""People of a few cells, and two who cross before a camera, for tests of joint tracking."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import scenes

from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person, PersonEvidence
from pointbrush.tracking.sensors.view import View

OPTIONS = TrackerOptions()


UP = np.array([0.0, -1.0, 0.0])


RATE = 5.0


SURE = PersonEvidence(
    fit=0.5,
    disputed=0.0,
    size=0.9,
    change=1.0,
    shown=0.9,
    like=0.0,
    back=False,
    touching=0.0,
    wider=0.0,
    astray=0.0,
)


RED, BLUE = np.array([0.4, 0.0, 0.5], np.float32), np.array([-0.4, 0.1, 0.5], np.float32)


def overlap(found: np.ndarray, truth: np.ndarray) -> float:
    mask = np.zeros(len(truth), np.bool_)
    mask[found] = True
    return float((mask & truth).sum() / (mask | truth).sum())


def crossing(stranger: bool, frames: int = 12, *, ball: bool = False) -> list[scenes.Frame]:
    """1 and 2 cross, one behind the other, five frames a second; a third comes in later.

    ``ball``: there is a ball on the floor too, 3.
    """
    rng = np.random.default_rng(7)
    sensor = scenes.Sensor(192, 168, 130.0, origin=np.array([0.0, 1.3, 0.0]))
    camera = scenes.Camera(sensor, scenes.room())
    made = []
    for i in range(frames):
        t = i / RATE
        one, two = np.array([1.1 * t - 1.1, 0, 2.4]), np.array([1.2 - 1.1 * t, 0, 3.2])
        parts = scenes.person(1, one, np.pi / 2, 7.0 * t, (60, 110, 200))
        parts += scenes.person(2, two, -np.pi / 2, 7.0 * t + 1, (190, 80, 60))
        if stranger:
            three = np.array([3.2 - 1.4 * t, 0, 2.8])
            parts += scenes.person(3, three, -np.pi / 2, 8.0 * t + 2, (70, 160, 80))
        if ball:
            at = np.array([0.7, 0.08, 2.8])
            parts.append(scenes.Part(3, (220, 190, 60), at, at + 1e-3, 0.08, 0.08))
        made.append(camera.shoot(parts, rng))
    return made


def body(right: float, colour: np.ndarray, tall: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Middles (30, 3) of cells 0.1 m apart, three metres away, and their colours."""
    across, down = np.meshgrid(np.arange(3) / 10, np.arange(10) / 10 - tall)
    middle = np.stack([right + across.ravel(), down.ravel(), np.full(30, 3.0)], axis=1)
    return middle, np.tile(colour, (30, 1))


def staged(*bodies: tuple[np.ndarray, np.ndarray], coloured: bool = True) -> PersonObservation:
    """The bodies, five points in each cell."""
    middle, colour = (np.vstack(each) for each in zip(*bodies, strict=True))
    many = np.full(len(middle), 5)
    cell = np.repeat(np.arange(len(middle)), 5)
    cells = Foreground(OPTIONS, np.arange(len(cell)), cell, many, middle, colour, 0.1, many)
    view = SimpleNamespace(
        options=OPTIONS,
        frame=SimpleNamespace(rgb=True if coloured else None),
        xyz=middle[cell],
        cells=SimpleNamespace(cell=np.append(np.full(len(cell), 50), [0, 99])),
        image_shape=(1, 100),
        colour=lambda points: colour[cell[points]],
        range_to=lambda xyz: xyz[:, 2],
        depth=np.full(1, np.inf),
        sees_through=lambda xyz, margin: view.depth[0] > xyz[:, 2] + margin,
        hides=lambda xyz, _: np.zeros(len(xyz), np.bool_),
    )
    return PersonObservation(cast(View, view), cells, np.eye(3)[:, [0, 2]], UP, cell[:0])


def staged_person(label: int, right: float, colour: np.ndarray, last_clear: int) -> Person:
    middle, tints = body(right, colour)
    person = Person.first_seen(
        OPTIONS, label, middle, tints, 0, ColourHistogram.of(tints, OPTIONS.appearance)
    )
    person.last_clear, person.area = last_clear, 30 * 5 * 9.0
    return person


def as_tall(label: int, right: float, tall: float) -> Person:
    person = staged_person(label, right, RED, last_clear=9)
    person.identity.stature.tops = [tall, tall]
    return person
