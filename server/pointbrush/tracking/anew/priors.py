"""Numbers of the labelling energy: a row per kind of object.  Energies are in nats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt

Kind = Literal["held", "soft"]


@dataclass(frozen=True, slots=True)
class Priors(Options):
    """Energy of a point under each label, for one kind of object."""

    known_reaches: PositiveFloat = 0.75  # deviation, in reaches, of points from known surface
    unlike_nats: float = 1.5  # most that unlike colours cost on known surface
    on_known_nats: float = 2.0  # energy under which a point is on known surface
    still_nats: float = 2.22  # a moving object where an unlabelled surface was as deep before
    unsure_nats: float = 0.37  # known surface that was seldom seen
    new_nats: float = 3.63  # new surface
    growth_nats: float = 3.27  # new surface, for each radius of distance from known surface
    growth_cap_nats: float = 2.0  # most of that while the object's extent is unknown
    carved_nats: float = 1.36  # a place that earlier views looked through
    colour_nats: float = 0.45  # new surface, for each nat of log ratio of its colours
    closed_nats: float = 6.08  # an unexplained component that ends all round
    closed_slow_nats: float = 5.5  # the same beside objects nearly at rest, which show no new sides
    pocket_nats: float = 3.31  # the same, beside known surface that a larger mover touches
    open_nats: float = 0.52  # a component that goes on: an arm, a body
    was_there_nats: float = 3.35  # less for a component that was there in the last frame
    was_there_share: float = 0.7  # share of it from which it was there
    other_nats: float = 1.11  # surface of another mover, where it was or carried along
    other_reaches: PositiveFloat = 1.14  # deviation of it
    other_near_nats: float = 2.5  # more for surface near it
    other_near_reaches: PositiveFloat = 2.5  # deviation of that
    other_closed_nats: float = 4.24  # least energy of another mover in a closed component
    clutter_nats: float = 2.42  # a flying pixel
    clutter_neighbour_nats: float = 1.5  # more for each further neighbour as deep


PRIORS: Mapping[Kind, Priors] = {
    "held": Priors(),
    "soft": Priors(known_reaches=1.0, new_nats=2.5),
}


@dataclass(frozen=True, slots=True)
class EnergyOptions(Options):
    """Numbers of the energy that no kind changes."""

    cap_nats: float = 9.0  # most that one term may cost
    blocked_nats: float = 50.0  # a label that a point cannot have
    pair_nats: float = 1.62  # two linked neighbours with different labels
    link_units: PositiveFloat = 3.0  # deviation of depths of linked neighbours
    joined_units: PositiveFloat = 4.0  # depth step of neighbours in one component
    link_colour: PositiveFloat = 0.12  # deviation of colours of linked neighbours
    link_floor: float = 0.3  # share of a link that no colour cuts
    sweeps: PositiveInt = 12  # sweeps of the mean field at most
    open_sizes: float = 1.0  # sizes of a slow object from which a component beside it is open
    longer_radii: float = 2.0  # radii around a moving object that components are followed
    far_radii: float = 3.0  # radii from known surface within which new surface may lie
    close_reaches: float = 6.0  # reaches from the model within which distances are exact
    rough_points: PositiveInt = 100  # model points that give greater distances
    open_gap_nats: float = 6.0  # energy over the least of a label that a node may still get
    touching_points: int = 3  # points on known surface that make a component the track's
    unknown_units: float = 40.0  # least radius, in units, while it is not
    learn_posterior: float = 0.9  # posterior from which points teach the model
    learn_reaches: float = 3.0  # reaches around other movers without new surface
    neutral_reaches: float = 5.0  # reaches around the model without other movers
    level_units: float = 2.0  # depth step to neighbours that are as deep
    behind_units: float = 4.0  # depth step to neighbours that a flying pixel lies behind
    isolated_share: float = 0.03  # share of other points in the component of an isolated object


@dataclass(frozen=True, slots=True)
class NextOptions:
    """The numbers of `auto-next` that `auto` does not have."""

    priors: Mapping[Kind, Priors] = field(default_factory=lambda: PRIORS)
    energy: EnergyOptions = field(default_factory=EnergyOptions)
