"""Frozen state of a track."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from pointbrush.tracking.anew.priors import Kind
from pointbrush.tracking.compute.grid import bounds
from pointbrush.tracking.interface import F32, F64, I64, Mask
from pointbrush.tracking.model.appearance import ColourHistogram
from pointbrush.tracking.model.motion import Motion
from pointbrush.tracking.model.painted import Painted
from pointbrush.tracking.model.surface import CarvingView, Model
from pointbrush.tracking.model.track import SIDES, LastObservation, OtherMovers
from pointbrush.tracking.model.track import Track as AutoTrack
from pointbrush.tracking.model.track import begin as painted_object
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, eq=False)
class Track:
    """A label followed over time; every step returns a new value.

    ``model`` is never changed in place.  ``around``: colours of its surroundings where it was
    painted; ``weight``: metres per unit of colour; ``unit``: tolerance in metres.
    """

    options: TrackerOptions
    label: int
    kind: Kind
    model: Model
    motion: Motion
    weight: float
    unit: float
    others: OtherMovers
    painted: Painted
    appearance: ColourHistogram
    around: tuple[ColourHistogram, ...]
    last: LastObservation
    size: float
    usual_cost: float
    frames_alone: int = 0
    frames_unseen: int = 0
    frames_astray: int = 0
    lost: bool = False
    confidence: float = 1.0
    views: tuple[CarvingView, ...] = ()
    strain: float = 0.0

    carrier = None
    stands = large = body = scanned = bends = absent = False
    hand_sized = rigid = True

    @property
    def as_auto(self) -> AutoTrack:
        """The track for the steps of `auto`, which read only fields of both kinds of track."""
        return cast(AutoTrack, self)

    @property
    def soft(self) -> bool:
        """Whether its surface deforms."""
        return self.kind == "soft"

    @property
    def has_colour_key(self) -> bool:
        """Whether colours identify it."""
        return self.weight > 0.0

    @property
    def span(self) -> float:
        """Radius (m) of the model."""
        return self.model.radius

    @property
    def reach(self) -> float:
        """Distance (m) up to which a model point represents a measured point."""
        return max(self.unit, self.model.spacing)

    @property
    def ends(self) -> F64:
        """(6, 3) extremes of the model along the axes."""
        return self.model.centre + self.model.radius * SIDES

    @property
    def slow(self) -> bool:
        """Whether it is nearly at rest."""
        return self.motion.slow(self.unit)

    @property
    def extent_known(self) -> bool:
        """Whether it was seen alone often enough, or rests."""
        return self.frames_alone >= self.options.growth.known_frames or self.slow

    def over_clothes(self, colour: F32) -> F32:
        """Return zeros: no person is tracked."""
        return np.zeros(len(colour), np.float32)

    def log_ratio(self, colour: F32) -> F32:
        """Return (M,) the log ratio of the shares of colours (M, 3) here and around."""
        if not (self.has_colour_key and self.around):
            return np.zeros(len(colour), np.float32)
        other = np.max([each.each(colour) for each in self.around], axis=0)
        return np.asarray(self.appearance.each(colour) - other, np.float32)

    def distinct(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that only this object had where it was painted."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.only(colour)

    def strange(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that the object did not have where it was painted."""
        if not self.has_colour_key:
            return np.zeros(len(colour), np.bool_)
        return self.appearance.strange(colour)


def begin(view: View, label: int, indices: I64, noise: float) -> Track:
    """Return a track of the painted points ``indices``; ``noise``: depth noise there (m)."""
    made = painted_object(view, label, indices, noise, OtherMovers.none())
    return Track(
        view.options,
        label,
        "held",
        made.model,
        made.motion,
        made.weight,
        made.unit,
        made.other_movers,
        made.painted,
        made.appearance,
        (),
        made.last,
        made.size,
        made.usual_cost,
    )


def in_its_place(track: Track, view: View, tracks: list[Track]) -> Track:
    """Return the track with its other movers, and with colours compared to its surroundings."""
    options = view.options
    unlabelled = ~view.labelled()

    def near(margin: float) -> I64:
        lo, hi = bounds(track.model.xyz)
        points = view.box(lo - margin, hi + margin)
        return points[unlabelled[points]]

    context = options.context
    beside = near(context.beside_radii * track.model.radius + context.beside_units * track.unit)
    about = view.colour(near(context.reach_m))
    others = [each.appearance for each in tracks if each is not track]
    beside_colours = ColourHistogram.of(view.colour(beside), options.appearance)
    appearance = track.appearance.apart_from([beside_colours, *others])
    appearance = appearance.commoner_than(about, track.size)
    # Colours of other tracks are other tracks' matter: the registered surfaces decide there.
    around = (beside_colours, ColourHistogram.of(about, options.appearance))
    track = replace(track, appearance=appearance, around=around)
    return with_others(track, view, beside, (np.full(3, -np.inf), np.full(3, np.inf)))


def with_others(track: Track, view: View, indices: I64, box: tuple[F64, F64]) -> Track:
    """Return the track with the points (M,) as other movers beside it, without its own colours."""
    some = indices[:: max(1, -(-len(indices) // track.options.context.max_points))]
    colour = view.colour(some)
    if track.has_colour_key and len(some):
        others = ~(track.appearance.overrepresented(colour) | track.distinct(colour))
        some, colour = some[others], colour[others]
    movers = OtherMovers(view.xyz[some].astype(np.float64), colour, track.weight, box)
    return replace(track, others=movers)
