"""Background model of a camera at rest: unlabelled points that stood still are no object's.

Here with a depth image: the farthest depth that each pixel has shown, and how much depth wavers at
that distance (measured on the recording itself).  Without one see ``scans.py``.
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
    again,
    before,
    furniture,
    keep_up,
    least,
    scenery,
    stood,
    take_in,
)
from pointbrush.tracking.sensors.view import View

NEVER = 1_000_000
"""More frames than a recording has."""


class Background(Protocol):
    """Background model: learns each frame after its labels were decided.

    Asked of the points ``indices`` (M,), in stored order, of the frame after those.  A kind of
    background that cannot know what is asked says of no point that it is so.
    """

    def static(self, view: View, indices: I64, /) -> tuple[Mask, Mask]:
        """Mark the points (M,) of the background, and those of an unlabelled object at rest."""

    def faint(self, view: View, indices: I64, /) -> Mask:
        """Mark the background's points (M,) that may belong to an object touching it there."""

    def scenery(self, view: View, indices: I64, frames: int, /) -> Mask:
        """Mark the points (M,) of the background.

        Also what has just been uncovered where the scene goes on, and what, where no background
        has been seen, has stood still for so many ``frames``, labelled or not.
        """

    def certain(self, view: View, indices: I64, /) -> Mask:
        """Mark the points (M,) before a background that has been seen."""

    def again(self, view: View, indices: I64, /) -> I64:
        """(M,) label of which the points (M,) show again, just as deep, what was last seen there.

        0 for none, and where the scene behind is known.
        """

    def learn(self, view: View, first: bool = False, keep: F64 | None = None) -> None:
        """Take in a frame whose ``labels`` are decided; ``first``: by a person.

        ``keep`` (M, 3) where something is though it claimed no point there.
        """


@runtime_checkable
class PictureBackground(Background, Protocol):
    """Of a depth camera, whose pictures show people before a scene; ``noise`` of its depth."""

    options: TrackerOptions
    noise: DepthNoise

    def furniture(self, view: View, indices: I64) -> Mask:
        """Mark the points (M,) no nearer than surface that stood before the scene for a while."""

    def left_behind(self, label: int, frames: int, way: float) -> None:
        """Make scenery of surface with a ``label`` that has been as deep for so many ``frames``, in
        which its owner has gone a ``way`` (m). Where the scene behind is known, that tells."""


@dataclass(eq=False)
class ImageBackground:
    """The farthest depth of every pixel, and the last; the sensor stands still."""

    options: TrackerOptions
    noise: DepthNoise
    depth: F32
    last: F32
    scene: F32 = field(init=False)
    """The depth behind all that ever moves, as far as the recording shows it; NaN elsewhere."""
    hidden: F32 = field(init=False)
    """Depth of the scene expected behind what was labelled in the first frame."""
    nearest: F32 | None = None
    """See ``least``; None where ``depth`` has changed since."""
    anchor: F32 = field(init=False)
    """The depth that each cell, labelled or not, has had for ``age`` frames."""
    age: NDArray[np.int32] = field(init=False)
    previous: F32 = field(init=False)
    """The last frame's depth, labelled or not."""
    owner: NDArray[np.int32] = field(init=False)
    """The last frame's label of each cell, 0 for none."""
    held: LastSeen = field(init=False)

    def __post_init__(self) -> None:
        """Nothing is known of hidden places before the first frame."""
        self.hidden = self.previous = self.scene = np.full_like(self.depth, np.nan)
        self.anchor, self.age = self.hidden.copy(), np.zeros(len(self.depth), np.int32)
        self.owner = np.zeros(len(self.depth), np.int32)
        self.held = LastSeen.nothing(len(self.depth))

    def static(self, view: View, indices: I64) -> tuple[Mask, Mask]:
        """See ``Background``."""
        return stood(
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
        """The scene's depth, and where the recording does not show it what was learnt so far."""
        return np.where(np.isfinite(self.scene), self.scene, self.depth)

    def survey(self, first: View, others: Sequence[View]) -> None:
        """Look through a recording for what its moving objects uncover.

        ``first`` has labels and has been learnt.  What took the place of something labelled may
        be another side of it, or another person: it is scenery where the scene around goes on, or
        where it lies well behind, stays, and goes on beside what is labelled.
        """
        options = self.options.background
        scene, count = farthest(
            (view.depth[:-1] for view in [first, *others]), self.noise, options=options
        )
        scene[count < max(options.min_showing_frames, options.seldom_share * (1 + len(others)))] = (
            np.nan
        )
        shape = first.camera.shape
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
        # At an outline pixels lie between the object and the scene, and are neither's.
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

        A foot stands too, and a side of a person may slide along itself: they are small.
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
        """The depth that something has to come before in each cell to be no part of the scene."""
        if self.nearest is None:
            self.nearest = least(self._known, view.camera.shape, self.noise)
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

    def again(self, view: View, indices: I64) -> I64:
        """See ``Background``."""
        sigmas = self.options.background.near_sigmas
        return again(view.cells, indices, self.held, self.noise, sigmas)

    def learn(self, view: View, first: bool = False, keep: F64 | None = None) -> None:
        """See ``Background``."""
        options = self.options.background
        seen = view.depth.copy()
        cell = view.cells.cell
        self.owner[:] = 0
        for label, points in view.labels.items():
            self.owner[cell[points]] = label
        labelled = self.owner != 0
        # What shows behind a depth, and is an object's, shows that something had only passed there.
        limit = np.float32(options.near_sigmas) * self.noise(seen)
        self.depth[labelled & (seen > self.depth + limit)] = np.nan
        labelled |= self.held.learn(seen, self.owner, limit, self._known, options=options)
        if keep is not None and len(keep):
            labelled[view.project(keep).cell] = True
            labelled[-1] = False
        if first:
            beyond = drawn_on(seen[:-1], view.camera.shape, labelled[:-1], options=options)
            self.hidden = np.append(beyond, np.float32(np.nan))
        self.previous = view.depth
        keep_up(self.anchor, self.age, seen, limit)
        if not first and labelled[:-1].any():  # the last entry is what lies outside the picture
            # What a run missed at an object's rim must not become background.
            image = labelled[:-1].reshape(view.camera.shape)
            rows, columns = np.flatnonzero(image.any(1)), np.flatnonzero(image.any(0))
            top, left = (max(rows[0] - options.rim_px, 0), max(columns[0] - options.rim_px, 0))
            part = image[
                top : rows[-1] + options.rim_px + 1, left : columns[-1] + options.rim_px + 1
            ]
            part[...] = widened(part, options.rim_px)
        seen[labelled] = np.nan
        self.last = seen
        take_in(self.depth, seen, limit, options.learn_rate)
        self.nearest = None
