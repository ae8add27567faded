"""Background model of a camera at rest: static unlabelled points belong to no object.

With a depth image it consists of the farthest depth of each pixel and the depth noise at that
distance, measured on the recording.  ``scans.py`` has the model without depth images.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.compute.grid import widened
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.scene.images import DepthNoise, continued, drawn_on, farthest
from pointbrush.tracking.scene.pixels import (
    Images,
    LastSeen,
    before,
    count_static_frames,
    furniture,
    least,
    reappearing_labels,
    scenery,
    static_points,
    update_known_depths,
)
from pointbrush.tracking.sensors.view import View

NEVER = 1_000_000
"""Number of frames above that of any recording."""


class Background(Protocol):
    """Background model, updated with each frame after its labels are final.

    Queries are for the points ``indices`` (M,), in stored order, of the following frame.  A model
    that cannot answer a query marks no point.
    """

    def static(self, view: View, indices: I64, /) -> tuple[Mask, Mask]:
        """Mark the points (M,) of the background, and points of unlabelled objects at rest."""

    def faint(self, view: View, indices: I64, /) -> Mask:
        """Mark the background's points (M,) that may belong to an object touching it there."""

    def scenery(self, view: View, indices: I64, frames: int, /) -> Mask:
        """Mark the points (M,) of the background.

        They include newly uncovered points that continue the scene and, where no background has
        been seen, points that were static for ``frames`` frames, labelled or not.
        """

    def certain(self, view: View, indices: I64, /) -> Mask:
        """Mark the points (M,) in front of a background that has been seen."""

    def reappearing_labels(self, view: View, indices: I64, /) -> I64:
        """Return (M,) the former label of points (M,) that reappear at the same depth.

        It is 0 for other points, and where the scene behind is known.
        """

    def learn(self, view: View, first: bool = False, keep: F64 | None = None) -> None:
        """Update the model with a frame with final ``labels``; ``first``: painted by a person.

        ``keep`` (M, 3): positions of objects without claimed points, excluded from the background.
        """


@runtime_checkable
class PictureBackground(Background, Protocol):
    """Background of a depth camera with ``noise``, to separate people from a scene."""

    options: TrackerOptions
    noise: DepthNoise

    def furniture(self, view: View, indices: I64) -> Mask:
        """Mark the points (M,) on or behind surface that was static in front of the scene."""

    def left_behind(self, label: int, frames: int, way: float) -> None:
        """Add surface with a ``label`` that was static for ``frames`` frames to the background.

        Its owner has moved a ``way`` (m) meanwhile.  Pixels with a known scene are unchanged.
        """


@dataclass(eq=False)
class ImageBackground:
    """Farthest and last depth of each pixel, for a sensor at rest."""

    options: TrackerOptions
    noise: DepthNoise
    depth: F32
    last: F32
    scene: F32 = field(init=False)
    """Depth behind all moving objects, as far as the recording shows it; NaN elsewhere."""
    hidden: F32 = field(init=False)
    """Expected depth of the scene behind labelled points of the first frame."""
    nearest: F32 | None = None
    """Cached result of ``least``; None if ``depth`` has changed since."""
    anchor: F32 = field(init=False)
    """Depth of each cell, labelled or not, for the last ``age`` frames."""
    age: NDArray[np.int32] = field(init=False)
    previous: F32 = field(init=False)
    """Depth of the last frame, labelled or not."""
    owner: NDArray[np.int32] = field(init=False)
    """Label of each cell in the last frame, 0 for none."""
    held: LastSeen = field(init=False)

    def __post_init__(self) -> None:
        """Start without knowledge of hidden places."""
        self.hidden = self.previous = self.scene = np.full_like(self.depth, np.nan)
        self.anchor, self.age = self.hidden.copy(), np.zeros(len(self.depth), np.int32)
        self.owner = np.zeros(len(self.depth), np.int32)
        self.held = LastSeen.nothing(len(self.depth))

    def static(self, view: View, indices: I64) -> tuple[Mask, Mask]:
        """See ``Background``."""
        return static_points(
            view.cells,
            indices,
            self.depth,
            self.last,
            self.noise,
            self.options.background.near_sigmas,
        )

    def faint(self, view: View, indices: I64) -> Mask:
        """See ``Background``."""
        options = self.options.background
        cell, depth = view.cells.pick(indices)
        before = (self.depth[cell] - depth) / self.noise(depth)
        return np.asarray((before > options.faint_sigmas) & (before <= options.near_sigmas))

    def scenery(self, view: View, indices: I64, frames: int) -> Mask:
        """See ``Background``."""
        options = self.options.background
        return scenery(
            view.cells,
            indices,
            frames,
            self._before(view),
            self._images,
            options.hidden_share,
            options.near_sigmas,
        )

    @property
    def _known(self) -> F32:
        """Depth of the scene, or the learnt depth where the recording does not show it."""
        return np.where(np.isfinite(self.scene), self.scene, self.depth)

    def survey(self, first: View, others: Sequence[View]) -> None:
        """Learn the scene uncovered by moving objects in other frames of a recording.

        ``first``: labelled frame, already learnt.  Surface in place of a labelled object may be
        another side of it or another person.  It is scenery if it continues the scene around, or if
        it is far behind, static and continues beside the labelled points.
        """
        options = self.options.background
        scene, count = farthest(
            (view.depth[:-1] for view in [first, *others]), self.noise, options=options
        )
        scene[count < max(options.min_showing_frames, options.seldom_share * (1 + len(others)))] = (
            np.nan
        )
        shape = first.image_shape
        known = np.isfinite(scene)
        for points in first.labels.values():
            known[first.cells.cell[points]] = False
        joined = continued(scene, known, shape, options=options)
        for points in first.labels.values():
            cell, depth = first.cells.pick(points)
            apart = options.side_share * float(np.ptp(first.xyz[points], axis=0).max())
            behind = scene[cell] > depth + options.near_sigmas * self.noise(depth)
            behind &= scene[cell] > options.same_depth_share * self.hidden[cell]
            stays = count[cell] > options.often_share * (1 + len(others))
            stays &= joined[cell] & (scene[cell] > depth + apart)
            scene[cell[~(behind | stays)]] = np.nan
        self.scene[:-1] = scene
        # Pixels at an outline lie between object and scene and belong to neither.
        self.depth[self.depth < options.same_depth_share * self.hidden] = np.nan
        self.nearest = None

    def certain(self, view: View, indices: I64) -> Mask:
        """See ``Background``."""
        return before(
            view.cells,
            indices,
            self._before(view),
            self.noise,
            self.options.background.near_sigmas,
        )

    def furniture(self, view: View, indices: I64) -> Mask:
        """See ``PictureBackground``."""
        sigmas = self.options.background.near_sigmas
        return furniture(view.cells, indices, self.depth, self.scene, self.noise, sigmas)

    def left_behind(self, label: int, frames: int, way: float) -> None:
        """See ``PictureBackground``.

        Small static surface is ignored: a standing foot, or a side of a body sliding along itself.
        """
        options = self.options.background
        labelled = np.flatnonzero(self.owner == label)
        stands = labelled[np.isnan(self.scene[labelled]) & (self.age[labelled] >= frames)]
        limit = options.near_sigmas * self.noise(self.anchor[stands])
        stands = stands[way > options.departed_sigmas * limit]
        if len(stands) > options.foot_share * len(labelled):
            self.depth[stands] = self.anchor[stands]
            self.nearest = None

    def _before(self, view: View) -> F32:
        """Return the depth (cells + 1,) below which a point is in front of the scene."""
        if self.nearest is None:
            self.nearest = least(self._known, view.image_shape, self.noise)
        return self.nearest

    @property
    def _images(self) -> Images:
        return Images(
            noise=self.noise,
            scene=self.scene,
            depth=self.depth,
            hidden=self.hidden,
            previous=self.previous,
            anchor=self.anchor,
            age=self.age,
        )

    def reappearing_labels(self, view: View, indices: I64) -> I64:
        """See ``Background``."""
        sigmas = self.options.background.near_sigmas
        return reappearing_labels(view.cells, indices, self.held, self.noise, sigmas)

    def learn(self, view: View, first: bool = False, keep: F64 | None = None) -> None:
        """See ``Background``."""
        options = self.options.background
        seen = view.depth.copy()
        cell = view.cells.cell
        self.owner[:] = 0
        for label, points in view.labels.items():
            self.owner[cell[points]] = label
        labelled = self.owner != 0
        # A labelled point behind a learnt depth shows that this depth was a passing object's.
        limit = np.float32(options.near_sigmas) * self.noise(seen)
        self.depth[labelled & (seen > self.depth + limit)] = np.nan
        labelled |= self.held.learn(seen, self.owner, limit, self._known, options=options)
        if keep is not None and len(keep):
            for cell, _ in view.project(keep):
                labelled[cell] = True
            labelled[-1] = False
        if first:
            width = view.image_shape[1]
            beyond = [
                drawn_on(seen[cells], (len(seen[cells]) // width, width), labelled[cells], options)
                for cells in view.pictures
            ]
            self.hidden = np.append(np.concatenate(beyond), np.float32(np.nan))
        self.previous = view.depth
        count_static_frames(self.anchor, self.age, seen, limit)
        if not first and labelled[:-1].any():  # the last entry is outside the picture
            # Missed points at an object's rim must not become background.
            image = labelled[:-1].reshape(view.image_shape)
            rows, columns = np.flatnonzero(image.any(1)), np.flatnonzero(image.any(0))
            top, left = (max(rows[0] - options.rim_px, 0), max(columns[0] - options.rim_px, 0))
            part = image[
                top : rows[-1] + options.rim_px + 1, left : columns[-1] + options.rim_px + 1
            ]
            part[...] = widened(part, options.rim_px)
        seen[labelled] = np.nan
        self.last = seen
        update_known_depths(self.depth, seen, limit, options.learn_rate)
        self.nearest = None
