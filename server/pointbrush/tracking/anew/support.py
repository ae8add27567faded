"""Nodes of the labelling energy: the pixels around tracks, their links and components."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.compiled import compiled
from pointbrush.tracking.anew.priors import EnergyOptions
from pointbrush.tracking.anew.track import Track
from pointbrush.tracking.compute.graph import Paths, parts, paths_into
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.scene.depth import Background, ImageBackground
from pointbrush.tracking.sensors.camera import I32
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, eq=False)
class Window:
    """Nodes (M,) that a track may have: ``nodes``, and the mask ``may`` (M,) of possible ones."""

    nodes: I64
    may: Mask


@dataclass(frozen=True, eq=False)
class Support:
    """Nodes (S,) of a frame.

    ``index``: their points; ``moving``: in front of the background; ``still``: unlabelled and at
    the same depth in the last frame; ``edge``: in no track's own box, so that their component goes
    on; ``background``: energy of being background.
    """

    view: View
    unit: float
    energy: EnergyOptions
    index: I64
    moving: Mask
    still: Mask
    edge: Mask
    background: F64
    windows: dict[int, Window]

    @cached_property
    def colour(self) -> F32:
        """(S, 3) colours."""
        return self.view.colour(self.index)

    @cached_property
    def _links(self) -> tuple[I64, F64, Mask]:
        cell, depth = self.view.cells.pick(self.index)
        number = np.full(len(self.view.depth), -1, np.int32)
        number[cell] = np.arange(len(cell), dtype=np.int32)
        number[-1] = -1
        height, width = self.view.image_shape
        energy = self.energy
        return _linked(
            cell, depth, self.colour, number, (height, width),
            energy.link_units * self.unit, energy.link_colour, energy.link_floor,
            energy.joined_units * self.unit,
        )  # fmt: skip

    def around(self, some: Mask) -> tuple[I64, Paths]:
        """Return the marked nodes with their neighbours (A,), and their weighted links."""
        links, weight, _ = self._links
        either = some[links].any(axis=1)
        kept = some.copy()
        kept[links[either].ravel()] = True
        nodes = np.flatnonzero(kept)
        number = np.cumsum(kept) - 1
        among = kept[links].all(axis=1)
        return nodes, paths_into(number[links[among]], weight[among], np.ones(len(nodes), np.bool_))

    @cached_property
    def whole(self) -> I64:
        """(S,) connected component of each moving node; -1: others."""
        return self.components(self.moving)

    def components(self, some: Mask) -> I64:
        """Return (S,) the connected component of each node in ``some`` (S,); -1: others."""
        links, _, joined = self._links
        return parts(links[joined], some)

    @cached_property
    def neighbours(self) -> tuple[I64, Mask, Mask]:
        """Number (S,) of neighbours as deep; whether one is much nearer; whether one is no node.

        The last are neighbours at the depth of the node, such as the table under a cup.
        """
        cell, depth = self.view.cells.pick(self.index)
        energy = self.energy
        unit, is_node = self.unit, self.view.marked(self.index)
        return _neighbours(
            cell, depth, self.view.depth, is_node, self.view.image_shape,
            energy.level_units * unit, energy.behind_units * unit, energy.joined_units * unit,
        )  # fmt: skip

    @cached_property
    def goes_on(self) -> Mask:
        """Mark the nodes (S,) beyond which their component goes on: other places, or scenery."""
        return self.edge | (self.moving & self.neighbours[2])


def support_of(
    tracks: Iterable[Track],
    fits: dict[int, Registration],
    view: View,
    background: Background,
    free: Mask,
    energy: EnergyOptions,
) -> Support:
    """Return the nodes around the registered tracks."""
    some = np.zeros(len(view.xyz), np.bool_)
    inner = some.copy()
    found = [track for track in tracks if track.label in fits]
    boxes: dict[int, I64] = {}
    for track in found:
        lo, hi = fits[track.label].box
        margin = 0.0 if track.slow else energy.longer_radii * track.model.radius
        around = view.box(lo - margin, hi + margin)
        boxes[track.label] = around = around[free[around]]
        some[around] = True
        rim = 2.5 * track.unit
        own = view.box(lo - margin + rim, hi + margin - rim)
        inner[own] = True
    index = np.flatnonzero(some)
    far, still = background.static(view, index)
    faint = background.faint(view, index)
    kept = np.flatnonzero(~far | faint)
    index, far, still, faint = index[kept], far[kept], still[kept], faint[kept]
    number = np.full(len(view.xyz), -1)
    number[index] = np.arange(len(index))
    windows = {}
    for track in found:
        nodes = number[boxes[track.label]]
        nodes = nodes[nodes >= 0]
        may = (~far | faint)[nodes] if track.slow else ~(far | still)[nodes]
        windows[track.label] = Window(nodes, may)
    unit = float(np.median([track.unit for track in found])) if found else 0.01
    return Support(
        view, unit, energy, index, ~far, still, ~inner[index],
        _background_energy(view, background, index, energy.cap_nats), windows,
    )  # fmt: skip


def _background_energy(view: View, background: Background, index: I64, cap: float) -> F64:
    """Return (S,) the energy of being background: graded before a known depth."""
    if not isinstance(background, ImageBackground):
        return np.asarray(np.where(background.static(view, index)[0], 0.0, cap), np.float64)
    cell, depth = view.cells.pick(index)
    before = (background.depth[cell] - depth) / (np.sqrt(2.0) * background.noise(depth))
    energy = 0.5 * np.maximum(0.0, before) ** 2
    return np.asarray(np.minimum(np.nan_to_num(energy, nan=cap), cap), np.float64)


@compiled
def _linked(
    cell: I32,
    depth: F32,
    colour: F32,
    number: I32,
    shape: tuple[int, int],
    step: float,
    unlike: float,
    floor: float,
    joined: float,
) -> tuple[I64, F64, Mask]:
    """Return the links (P, 2) of neighbouring pixels, their weights, and which join components."""
    height, width = shape
    links, weight = np.empty((4 * len(cell), 2), np.int64), np.empty(4 * len(cell))
    joins, count = np.empty(4 * len(cell), np.bool_), 0
    for i in range(len(cell)):
        if cell[i] < 0:
            continue
        row, column = cell[i] // width, cell[i] % width
        for down, along in ((0, 1), (1, -1), (1, 0), (1, 1)):
            if row + down >= height or column + along < 0 or column + along >= width:
                continue
            other = number[cell[i] + down * width + along]
            if other < 0:
                continue
            change = abs(depth[i] - depth[other])
            near = np.exp(-0.5 * (change / step) ** 2)
            if near < 0.01 and change > joined:
                continue
            tint = 0.0
            for a in range(3):
                tint += (colour[i, a] - colour[other, a]) ** 2
            links[count, 0], links[count, 1] = i, other
            weight[count] = near * (floor + (1 - floor) * np.exp(-tint / unlike**2))
            joins[count] = change < joined
            count += 1
    return links[:count], weight[:count], joins[:count]


@compiled
def _neighbours(
    cell: I32,
    depth: F32,
    image: F32,
    is_node: Mask,
    shape: tuple[int, int],
    level: float,
    behind: float,
    joined: float,
) -> tuple[NDArray[np.int64], Mask, Mask]:
    height, width = shape
    like, hidden = np.zeros(len(cell), np.int64), np.zeros(len(cell), np.bool_)
    touches = np.zeros(len(cell), np.bool_)
    for i in range(len(cell)):
        row, column = cell[i] // width, cell[i] % width
        for down in (-1, 0, 1):
            for along in (-1, 0, 1):
                if cell[i] < 0 or (down == 0 and along == 0):
                    continue
                if not (0 <= row + down < height and 0 <= column + along < width):
                    continue
                other = cell[i] + down * width + along
                step = depth[i] - image[other]
                like[i] += abs(step) < level
                hidden[i] |= step > behind
                touches[i] |= abs(step) < joined and not is_node[other]
    return like, hidden, touches
