"""State of a tracked label: its model, motion and surroundings."""

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
"""(6, 3) unit vectors along the axes, in both directions."""


@dataclass(eq=False)
class OtherMovers:
    """Unlabelled points (M, 3) beside an object in the last frame, in the world, with colours."""

    xyz: F64
    colour: F32
    weight: float = 0.0
    """Metres per unit of colour."""
    box: tuple[F64, F64] | None = None
    """Corners (3,) of the searched box; None: unbounded."""

    @staticmethod
    def none() -> OtherMovers:
        """Return an empty set."""
        return OtherMovers(np.empty((0, 3)), np.empty((0, 3), np.float32))

    @cached_property
    def target(self) -> Target:
        """The points as a search target."""
        return Target(self.xyz, self.colour, self.weight)

    def in_searched_box(self, xyz: NDArray[np.floating]) -> Mask:
        """Mark the positions (M, 3) inside the searched box; outside, nothing is known."""
        return np.ones(len(xyz), np.bool_) if self.box is None else within(xyz, *self.box)

    def explain(self, xyz: F64, colour: F32, within: F64, step: F64 | None = None) -> Mask:
        """Mark the points (M,) closer than ``within`` (M,) to one of these, in place and colour.

        Their former positions count and, with a ``step``, also these moved by the object's step.
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

    ``imaged``: the sensor has depth images; ``scanned``: it is a lidar; ``grain``: metres between
    points of the object at a distance of ``distance`` metres, which is 0 if unknown.
    """

    imaged: bool
    scanned: bool
    grain: float
    distance: float = 0.0


@dataclass(frozen=True, slots=True)
class Bending:
    """Bending of an object, as running means.

    ``share``: share, 0 to 1, that a single rigid motion does not explain; ``strain``: share of its
    known surface that only bending explains.
    """

    share: float = 0.0
    strain: float = 0.0


@dataclass(frozen=True, slots=True)
class LastObservation:
    """Outcome of an object in its last visible frame.

    ``points``: their number; ``alternatives_failed``: whether its fit was doubtful and other poses
    were no better.
    """

    points: int
    alternatives_failed: bool = False
    evidence: Evidence | None = None
    """Evidence from its fit."""


@dataclass(frozen=True, slots=True, eq=False)
class Carrier:
    """Person ``label`` that carries an object, and its ``offset`` (2,) on the ground in m."""

    label: int
    offset: F64


@dataclass(eq=False)
class Track:
    """State of a label."""

    options: TrackerOptions
    label: int
    model: Model
    motion: Motion
    weight: float
    """Metres per unit of colour; 0 without distinctive colours."""
    unit: float
    """Tolerance in metres: spacing of its points or noise of the sensor."""
    other_movers: OtherMovers
    painted: Painted
    sampling: Sampling
    appearance: ColourHistogram
    """Colours in the painted frame."""
    last: LastObservation
    size: float
    """Maximum number of points so far."""
    usual_cost: float
    """Mean distance of its points to the model in frames alone in the air, in reaches."""
    frames_alone: int = 0
    """Number of frames alone in the air."""
    extent: float = 0.0
    """Maximum radius so far, in metres."""
    frames_unseen: int = 0
    """Frames since it was seen."""
    lost: bool = False
    """Whether the search for it has ended."""
    confidence: float = 1.0
    """Confidence in the last frame."""
    astray: bool = False
    """Whether it may be another object, since it was found far from all predictions with a doubtful
    fit, until it is seen alone."""
    clothes: tuple[ColourHistogram, ...] = ()
    """Clothes of the people tracked in the same run."""
    carrier: Carrier | None = None
    """The person who carried it at its last confident observation."""
    bending: Bending = Bending()
    carving_views: list[CarvingView] = field(default_factory=list)
    """Depth images of its surroundings in some frames."""

    @property
    def has_colour_key(self) -> bool:
        """Whether colours identify it; they do not for large objects and in lidar scans."""
        return self.weight > 0.0 and not self.large

    def distinct(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that only this object had in the painted frame."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.only(colour)

    def strange(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that the object did not have in the painted frame."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.strange(colour)

    def over_clothes(self, colour: F32) -> F32:
        """Return (M,) the log ratio of the shares of colours (M, 3) here and in people's clothes.

        The person with the largest share counts; it is 0 without people.
        """
        if not (self.clothes and self.has_colour_key):
            return np.zeros(len(colour), np.float32)
        worn = np.max([appearance.each(colour) for appearance in self.clothes], axis=0)
        return np.asarray(self.appearance.each(colour) - worn)

    @property
    def has_left_start(self) -> bool:
        """Whether the object has left its painted place."""
        distance = np.linalg.norm(self.motion.place - self.motion.centre)
        return bool(distance > self.model.radius)

    @property
    def bends(self) -> bool:
        """Whether a single rigid motion is not enough; small objects have a higher threshold."""
        options = self.options.track
        return self.bending.share > (
            options.bent_share_large if self.large and not self.scanned else options.bent_share
        )

    @property
    def rigid(self) -> bool:
        """Whether it is a small object that does not bend, so that one rigid motion applies."""
        return not (self.bends or self.large)

    @property
    def stiff(self) -> bool:
        """Whether its surface does not deform."""
        return not (self.bends or self.soft or self.large)

    def set_distance(self, distance: float) -> None:
        """Set the distance from the sensor: a nearer object has more points, more densely."""
        options = self.options.track
        grain = self.sampling.grain
        if self.sampling.distance > 0.0 and distance > 0.0:
            closer = float(
                np.clip(
                    self.sampling.distance / distance,
                    1 / options.max_approach,
                    options.max_approach,
                )
            )
            self.size *= closer**2
            grain /= closer
            unit = max(grain, options.min_unit_spacings * self.model.spacing)
            self.weight *= unit / self.unit
            self.unit = unit
        self.sampling = replace(self.sampling, grain=grain, distance=distance)

    @property
    def scanned(self) -> bool:
        """Whether the sensor is a lidar."""
        return self.sampling.scanned

    @property
    def soft(self) -> bool:
        """Whether it is a small object with a deforming surface, such as a soft toy."""
        return self.bending.strain > self.options.track.soft_strain and not self.large

    @property
    def large(self) -> bool:
        """Whether it is large, such as a person, or scanned by a lidar, and therefore not held."""
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
        """Whether it is large and the sensor has depth images."""
        return self.sampling.imaged and self.large

    @property
    def hand_sized(self) -> bool:
        """Whether it is small and the sensor has depth images: it may be thrown."""
        return self.sampling.imaged and not self.large

    @property
    def span(self) -> float:
        """Radius (m) around its middle that contains all of it, including hidden parts."""
        return max(self.model.radius, self.extent)

    @property
    def ends(self) -> F64:
        """(6, 3) extremes of the model along the axes; a motion that moves none moves no point."""
        return self.model.centre + self.model.radius * SIDES

    @property
    def absent(self) -> bool:
        """Whether it is large and mostly occluded; it is then matched after the other tracks.

        Excluded: static objects of a lidar, which reappear at their place.
        """
        mostly_occluded = (
            self.frames_unseen > 0 or self.last.points < self.options.track.hardly_share * self.size
        )
        return self.large and mostly_occluded and not self.stands

    @property
    def stands(self) -> bool:
        """Whether it was static in lidar scans when last seen, such as a parked car."""
        return self.scanned and self.motion.rests(self.unit)

    @property
    def reach(self) -> float:
        """Distance (m) up to which a model point represents a measured point."""
        return max(self.unit, self.model.spacing)


def begin(view: View, label: int, indices: I64, noise: float, other_movers: OtherMovers) -> Track:
    """Return a track of the painted points ``indices``; ``noise``: depth noise there (m).

    Flying pixels of a small object before a depth camera are left out; for a large object they do
    not matter.
    """
    track = _made(view, label, indices, noise, other_movers)
    if track.large:  # connected points are found at the full resolution
        track = _made(view, label, indices, noise, other_movers, most=len(indices))
    if view.lens is None:
        return track
    kept = solid(view.xyz[indices].astype(np.float64), track.unit, options=view.options.link)
    if not kept.all():
        without = _made(view, label, indices[kept], noise, other_movers)
        track = track if without.large else without
    if track.large and (track.painted.broad or track.painted.cut):
        # It stays large even if little of it is seen.
        track.extent = max(track.model.radius, view.options.track.tall_m)
    return track


def _coarsest_spacing(view: View, indices: I64, xyz: F64, colour: F32) -> float:
    """Return the greatest point spacing (m) of any sensor; 0.0 for a recording of one sensor.

    Where their points overlap, all together are denser than the surface that only one sees.
    """
    options, spacings = view.options.track, [0.0]
    for points in view.points_by_sensor if view.frame.sensor is not None else ():
        own = points[indices]
        if own.mean() > options.sensor_share:
            spacings.append(texture(xyz[own], colour[own], options=options)[0])
    return max(spacings)


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
    if not view.scans:  # no computation uses more points than these
        spacing *= float(np.sqrt(max(1.0, len(indices) / most)))
    coarsest = _coarsest_spacing(view, indices, xyz, colour)
    rings = options.track.ring_share * across_rings(xyz, options=options.track)
    unit = max(spacing, coarsest, noise, rings)
    weight = 0.0
    if view.frame.rgb is not None and not colourless(view, indices):
        weight = options.track.colour_units * unit / max(speckle, options.track.min_colour_noise)
    model = Model.of(xyz, colour, view.eyes_of(indices), spacing, options.surface)
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
