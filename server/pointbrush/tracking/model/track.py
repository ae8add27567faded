"""One label on its way through a recording: its model, its motion, what is beside it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pointbrush.tracking.compute.columns import nearer_than
from pointbrush.tracking.compute.graph import solid
from pointbrush.tracking.compute.grid import within
from pointbrush.tracking.compute.rigid import Target, inverse, transform
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.confidence import Evidence
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.painted import Painted, across_rings, colourless, texture
from pointbrush.tracking.model.surface import CarvingView, Model
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.view import View

SIDES = np.vstack([np.eye(3), -np.eye(3)])
"""(6, 3) unit vectors along the axes, both ways."""


@dataclass(eq=False)
class OtherMovers:
    """Unlabelled points beside an object in the last frame: (M, 3) world, with colours."""

    xyz: F64
    colour: F32
    weight: float = 0.0
    """Metres per unit of colour."""
    box: tuple[F64, F64] | None = None
    """Corners (3,) of where they were looked for; None for anywhere."""

    @staticmethod
    def none() -> OtherMovers:
        """Nothing unlabelled is known."""
        return OtherMovers(np.empty((0, 3)), np.empty((0, 3), np.float32))

    @cached_property
    def target(self) -> Target:
        """The points as a search target."""
        return Target(self.xyz, self.colour, self.weight)

    def asked(self, xyz: NDArray[np.floating]) -> Mask:
        """Mark the positions (M, 3) inside the searched box; of the others nothing is known."""
        return np.ones(len(xyz), np.bool_) if self.box is None else within(xyz, *self.box)

    def explain(self, xyz: F64, colour: F32, within: F64, step: F64 | None = None) -> Mask:
        """Mark the points (M,) less than ``within`` (M,) metres from one of these, in place and
        colour.

        Where they were, or, with a ``step``, gone along with the object's.
        """
        explained = np.zeros(len(xyz), np.bool_)
        if not len(self.xyz):
            return explained
        for back in [None] if step is None else [None, inverse(step)]:
            rest = np.flatnonzero(~explained)
            if not len(rest):
                break
            at = xyz[rest] if back is None else transform(back, xyz[rest])
            explained[rest] = nearer_than(self.target.columns, at, colour[rest], within[rest])
        return explained


@dataclass(frozen=True, slots=True)
class Sampling:
    """Sampling of an object by its sensor.

    ``imaged`` it sees depth images; ``scanned`` it is a lidar, then ``grain`` metres lie between
    the points of the object, as it is seen from ``away`` metres, 0 while that is not known.
    """

    imaged: bool
    scanned: bool
    grain: float
    away: float = 0.0


@dataclass(frozen=True, slots=True)
class Bending:
    """Bending of an object, as running means.

    ``share`` 0..1 of it that one rigid motion does not explain; ``strain`` share of its known
    surface that bending alone explains.
    """

    share: float = 0.0
    strain: float = 0.0


@dataclass(frozen=True, slots=True)
class LastObservation:
    """Outcome of an object in the last frame that showed it.

    ``points`` number of them; ``alternatives_failed`` whether other poses were tried, its fit being
    in doubt, and were no better.
    """

    points: int
    alternatives_failed: bool = False
    evidence: Evidence | None = None
    """Evidence from its fit."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """The person with a ``label``, and how far ``away`` (2,) from them, metres along the ground, an
    object was that they carry."""

    label: int
    away: F64


@dataclass(eq=False)
class Track:
    """State of a label."""

    options: TrackerOptions
    label: int
    model: Model
    motion: Motion
    weight: float
    """Metres per unit of colour; 0 where it has none that tell it."""
    unit: float
    """Metres of tolerance: spacing of its points or noise of the sensor."""
    other_movers: OtherMovers
    painted: Painted
    sampling: Sampling
    appearance: ColourHistogram
    """The colours that it was painted with."""
    last: LastObservation
    size: float
    """The most points that it had."""
    usual_cost: float
    """Mean distance of its points to the model where it was alone in the air, in reaches."""
    frames_alone: int = 0
    """Frames in which it was alone in the air."""
    extent: float = 0.0
    """Metres, the greatest radius that it had."""
    frames_unseen: int = 0
    """Frames since it was seen."""
    lost: bool = False
    """Whether it is not looked for any more."""
    confidence: float = 1.0
    """The last confidence."""
    astray: bool = False
    """Whether it may be another since it was found, in doubt, where no motion led, until it is
    seen alone."""
    clothes: tuple[ColourHistogram, ...] = ()
    """Clothes of the people beside whom it is followed."""
    carrier: Carrier | None = None
    """The person who carried it when it was last surely seen."""
    bending: Bending = Bending()
    carving_views: list[CarvingView] = field(default_factory=list)
    """Its surroundings in some frames."""

    @property
    def has_colour_key(self) -> bool:
        """Whether it is known by its colours; large objects and what a lidar sees are otherwise."""
        return self.weight > 0.0 and not self.large

    def distinct(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that the object alone had where it was painted."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.only(colour)

    def strange(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that the object did not show where it was painted."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.strange(colour)

    def over_clothes(self, colour: F32) -> F32:
        """(M,) how much commoner the colours (M, 3) are where it was painted than in the clothes of
        any of the people, a logarithm; 0 where there are none."""
        if not (self.clothes and self.has_colour_key):
            return np.zeros(len(colour), np.float32)
        worn = np.max([appearance.each(colour) for appearance in self.clothes], axis=0)
        return np.asarray(self.appearance.each(colour) - worn)

    @property
    def away(self) -> bool:
        """True once the object has left the place where it was painted."""
        went = np.linalg.norm(self.motion.place - self.motion.centre)
        return bool(went > self.model.radius)

    @property
    def bends(self) -> bool:
        """Whether one rigid motion is not enough; a small object has to show it more clearly."""
        options = self.options.track
        return self.bending.share > (
            options.bent_share_large if self.large and not self.scanned else options.bent_share
        )

    @property
    def rigid(self) -> bool:
        """True for a small object that does not bend: one motion moves all of it."""
        return not (self.bends or self.large)

    @property
    def stiff(self) -> bool:
        """True for an object whose surface does not move within itself."""
        return not (self.bends or self.soft or self.large)

    def come_to(self, away: float) -> None:
        """Be ``away`` metres from the sensor: what is nearer shows more points, and closer ones."""
        options = self.options.track
        grain = self.sampling.grain
        if self.sampling.away > 0.0 and away > 0.0:
            closer = float(
                np.clip(self.sampling.away / away, 1 / options.max_approach, options.max_approach)
            )
            self.size *= closer**2
            grain /= closer
            unit = max(grain, options.min_unit_spacings * self.model.spacing)
            self.weight *= unit / self.unit
            self.unit = unit
        self.sampling = replace(self.sampling, grain=grain, away=away)

    @property
    def scanned(self) -> bool:
        """Whether a lidar sees it."""
        return self.sampling.scanned

    @property
    def soft(self) -> bool:
        """Whether it is a small object whose surface moves within itself, as a toy's does."""
        return self.bending.strain > self.options.track.soft_strain and not self.large

    @property
    def large(self) -> bool:
        """Whether it is many points across, as people are, or seen by a lidar: no one holds it."""
        options = self.options.track
        if self.scanned:
            return True
        part = self.painted.cut or self.painted.broad
        part = part and self.sampling.imaged and self.span > options.part_units * self.unit
        return (
            part or self.span > max(options.tall_m, options.tall_units * self.unit)
        ) and not self.painted.sheet

    @property
    def body(self) -> bool:
        """Whether it is large and before a sensor that sees depth images."""
        return self.sampling.imaged and self.large

    @property
    def hand_sized(self) -> bool:
        """Whether it is small and before a sensor that sees depth images: it may be thrown."""
        return self.sampling.imaged and not self.large

    @property
    def span(self) -> float:
        """Metres from its middle that may hold all of it, hidden parts too."""
        return max(self.model.radius, self.extent)

    @property
    def ends(self) -> F64:
        """(6, 3) as far out as the model on every side: a motion that moves none moves nothing."""
        return self.model.centre + self.model.radius * SIDES

    @property
    def absent(self) -> bool:
        """Whether it is large and hardly anything of it was seen: the others come first then.

        But for what stands before a lidar: it comes out where it was, from behind who goes away.
        """
        hardly = (
            self.frames_unseen > 0 or self.last.points < self.options.track.hardly_share * self.size
        )
        return self.large and hardly and not self.stands

    @property
    def stands(self) -> bool:
        """Whether a lidar saw it stand still when it was last seen, as a parked car does."""
        return self.scanned and self.motion.rests(self.unit)

    @property
    def reach(self) -> float:
        """Metres between a point and the model's point that stands for it."""
        return max(self.unit, self.model.spacing)


def begin(view: View, label: int, indices: I64, noise: float, other_movers: OtherMovers) -> Track:
    """An object made of a person's points ``indices``; ``noise`` metres of the depth there.

    A small one before a depth camera without its flying pixels; among those of a large one they
    do not matter.
    """
    track = _made(view, label, indices, noise, other_movers)
    if track.large:  # what hangs together with it is found as finely as it is seen
        track = _made(view, label, indices, noise, other_movers, most=len(indices))
    if view.lens is None:
        return track
    kept = solid(view.xyz[indices].astype(np.float64), track.unit, options=view.options.link)
    if not kept.all():
        without = _made(view, label, indices[kept], noise, other_movers)
        track = track if without.large else without
    if track.large and (track.painted.broad or track.painted.cut):
        # It stays that, however little of it is seen.
        track.extent = max(track.model.radius, view.options.track.tall_m)
    return track


def _made(
    view: View,
    label: int,
    indices: I64,
    noise: float,
    other_movers: OtherMovers,
    most: int | None = None,
) -> Track:
    options = view.options
    xyz = view.xyz[indices].astype(np.float64)
    colour = view.colour(indices)
    most = most or options.track.dense_points
    spacing, speckle = texture(xyz, colour, options=options.track)
    if not view.scans:  # nothing that is asked of an object asks more points than these
        spacing *= float(np.sqrt(max(1.0, len(indices) / most)))
    unit = max(spacing, noise, options.track.ring_share * across_rings(xyz, options=options.track))
    weight = 0.0
    if view.frame.rgb is not None and not colourless(view, indices):
        weight = options.track.colour_units * unit / max(speckle, options.track.min_colour_noise)
    model = Model.of(xyz, colour, view.eye, spacing, options.surface)
    model.hits[:] = options.surface.sure_hits
    count = len(indices)
    return Track(
        view.options,
        label,
        model,
        Motion(options.search, model.centre),
        weight,
        unit,
        other_movers,
        Painted.of(view, indices, xyz, model.radius),
        Sampling(view.lens is not None, view.scans, grain=unit),
        ColourHistogram.of(colour, options.appearance),
        LastObservation(count),
        float(count),
        options.confidence.usual_cost,
    )
