"""Single frames of table tops and shelves with objects that touch, lean on and carry each other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.frame import DepthCamera
from pointbrush.samples.geometry import Array, rigid, vec, yaw
from pointbrush.samples.render import Solid, block
from pointbrush.samples.reproducible import cos, draw_normal, matmul, sin
from pointbrush.samples.sensor import KINECT, Sensor
from pointbrush.samples.textures import matte
from pointbrush_samples.furniture import Furniture, Rng, clutter, colour, material
from pointbrush_samples.scanning import Labelled, look_at, view_of


@dataclass(frozen=True, slots=True)
class ContactOptions:
    """Sizes and frequencies of the objects on a table top or shelf."""

    most_rows: int = 5
    """Rows of things on one board, at most."""
    most_side_by_side: int = 4
    """Things that stand side by side in a row, at most."""
    most_stacked: int = 3
    """Boxes on top of one another, at most."""
    flush: float = 0.7
    """Share of neighbours that touch; between the others is a gap."""
    widest_gap: float = 0.02
    """Metres between neighbours that do not touch, at most."""
    smallest_box: float = 0.05
    """Metres; shortest edge of a box."""
    largest_box: float = 0.24
    """Metres; longest edge of a box."""

    def check(self) -> None:
        """Raise BadInputError for numbers out of range."""
        if min(self.most_rows, self.most_side_by_side, self.most_stacked) < 1:
            raise BadInputError("most_rows, most_side_by_side, most_stacked: expected 1 or more")
        if not 0 <= self.flush <= 1:
            raise BadInputError(f"flush: expected a share, 0 to 1, got {self.flush}")
        if not 0 < self.smallest_box < self.largest_box:
            raise BadInputError("smallest_box: expected above 0 and below largest_box")


class _Display:
    """Solids of a table or a shelf and of its objects; labels from 1 in order of placing."""

    def __init__(self, rng: Rng, options: ContactOptions) -> None:
        self.solids: list[Solid] = []
        self._rng, self._options, self._count = rng, options, 0

    def add(self, furniture: Furniture, T_room_furniture: Array) -> None:
        """Place one thing and give it the next label."""
        self._count += 1
        self.solids += furniture.placed(T_room_furniture, self._count)

    def fill(self, width: float, depth: float, height: float, room: float) -> None:
        """Put rows of objects on a board centred above the origin; ``room``: free height."""
        rng = self._rng
        placed: list[tuple[float, float, float]] = []
        for _ in range(int(rng.integers(2, self._options.most_rows + 1))):
            row = self._row(room, min(0.9 * depth, width))
            length = sum(gap + column[0].width for gap, column in row)
            r = 0.5 * math.hypot(length, max(column[0].depth for _, column in row))
            for _ in range(20):
                x = rng.uniform(-1, 1) * max(width / 2 - r, 0)
                z = rng.uniform(-1, 1) * max(depth / 2 - 0.6 * r, 0)
                if all(math.hypot(x - a, z - b) > 0.85 * (r + c) for a, b, c in placed):
                    placed.append((x, z, r))
                    turn = rng.uniform(-0.6, 0.6) + math.pi / 2 * (rng.random() < 0.3)
                    self._stand(row, length, rigid(yaw(turn), vec(x, height, z)))
                    break

    def _row(self, room: float, longest: float) -> list[tuple[float, list[Furniture]]]:
        """Gaps and columns of a row, from left to right: boxes under a thing or a box."""
        rng, options = self._rng, self._options
        row: list[tuple[float, list[Furniture]]] = []
        length = 0.0
        for _ in range(int(rng.integers(1, options.most_side_by_side + 1))):
            gap = 0.0 if rng.random() < options.flush else rng.uniform(0, options.widest_gap)
            column = self._column(room)
            length += gap + column[0].width
            if row and length > longest:
                break
            row.append((gap, column))
        return row

    def _column(self, room: float) -> list[Furniture]:
        rng, options = self._rng, self._options
        column: list[Furniture] = []
        height = 0.0
        for _ in range(int(rng.integers(1, options.most_stacked + 1))):
            widest = column[-1].width if column else options.largest_box
            box = self._box(widest)
            if column and height + box.top > room:
                break
            column.append(box)
            height += box.top
        if rng.random() < 0.4 and height + 0.26 < room:
            thing = clutter(rng)
            if max(thing.width, thing.depth) < 1.1 * min(column[-1].width, column[-1].depth):
                column.append(thing)
        elif rng.random() < 0.3:
            return [clutter(rng)]
        return column

    def _box(self, widest: float) -> Furniture:
        rng, options = self._rng, self._options
        w, d = rng.uniform(options.smallest_box, max(widest, 1.2 * options.smallest_box), 2)
        h = rng.uniform(0.4, 1.0) * options.largest_box * rng.uniform(0.15, 1.0)
        solid = block((-w / 2, 0, -d / 2), (w / 2, h, d / 2), material(rng))
        return Furniture((solid,), w, d, h)

    def _stand(
        self, row: list[tuple[float, list[Furniture]]], length: float, T_room_row: Array
    ) -> None:
        rng, x = self._rng, -length / 2
        for gap, column in row:
            x += gap + column[0].width / 2
            y = 0.0
            for k, thing in enumerate(column):
                slack = 0.5 * (column[k - 1].width - thing.width) if k else 0.0
                aside = rng.uniform(-1, 1) * max(slack, 0.0)
                turn = draw_normal(rng, 0.05) if rng.random() < 0.5 else rng.uniform(-0.6, 0.6)
                T_row_thing = rigid(yaw(turn if k else 0.0), vec(x + aside, y, 0))
                self.add(thing, matmul(T_room_row, T_row_thing))
                y += thing.top
            x += column[0].width / 2


def contact_view(
    seed: int, camera: DepthCamera = KINECT, options: ContactOptions | None = None
) -> Labelled:
    """Render a depth camera's view of a full table top or shelf, camera coordinates."""
    options = options or ContactOptions()
    options.check()
    rng = np.random.default_rng([seed, 53])
    display = _Display(rng, options)
    floor, wall = material(rng), matte(colour(rng))
    display.solids += [
        block((-2.5, -0.1, -2.5), (2.5, 0, 2.5), floor),
        block((-2.5, 0, -2.6), (2.5, 2.6, -2.5), wall),
    ]
    middle = _shelf(display, rng) if rng.random() < 0.3 else _table(display, rng)
    distance, side = rng.uniform(0.7, 1.4), rng.uniform(-0.6, 0.6)
    up = rng.uniform(0.3, 0.9) * distance * (0.4 if middle[2] else 1.0)
    place = vec(*middle)
    eye = place + vec(distance * sin(side), up, distance * cos(side))
    T_room_camera = look_at(eye, place + draw_normal(rng, 0.06, 3))
    return view_of(display.solids, T_room_camera, camera, Sensor(), rng)


def _table(display: _Display, rng: Rng) -> tuple[float, float, float]:
    """Place a table; return the place that the camera looks at."""
    w, d, h = rng.uniform(0.8, 1.6), rng.uniform(0.6, 0.9), rng.uniform(0.4, 0.8)
    top = block((-w / 2, h - 0.03, -d / 2), (w / 2, h, d / 2), material(rng))
    display.add(Furniture((top,), w, d, h), np.eye(4))
    display.fill(w, d, h, room=0.6)
    return 0.0, h, 0.0


def _shelf(display: _Display, rng: Rng) -> tuple[float, float, float]:
    """Place a shelf of a few boards; return the place that the camera looks at."""
    w, d, stuff = rng.uniform(0.6, 1.2), rng.uniform(0.3, 0.45), material(rng)
    boards, apart = int(rng.integers(2, 4)), rng.uniform(0.3, 0.45)
    low = rng.uniform(0.2, 0.7)
    tall = low + boards * apart
    parts = [block((x - 0.01, 0, -d / 2), (x + 0.01, tall, d / 2), stuff) for x in (-w / 2, w / 2)]
    parts.append(block((-w / 2, 0, -d / 2), (w / 2, tall, -d / 2 + 0.01), stuff))
    heights = [low + k * apart for k in range(boards)]
    parts += [block((-w / 2, y - 0.02, -d / 2), (w / 2, y, d / 2), stuff) for y in heights]
    display.add(Furniture(tuple(parts), w, d), np.eye(4))
    for y in heights:
        display.fill(w - 0.1, d, y, room=apart - 0.05)
    return 0.0, heights[len(heights) // 2] + 0.1, d / 2
