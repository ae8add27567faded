"""The labelling energy: every node gets a posterior over tracks, background, others, clutter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from pointbrush.tracking.anew.priors import EnergyOptions, NextOptions, Priors
from pointbrush.tracking.anew.support import Support, Window, support_of
from pointbrush.tracking.anew.track import Track
from pointbrush.tracking.compute.graph import agreed
from pointbrush.tracking.compute.grid import close_to
from pointbrush.tracking.compute.rigid import Target, inverse, transform
from pointbrush.tracking.interface import F64, I64, Mask
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.surface import carved
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.claim import Claim, claim

OTHER, BACKGROUND, CLUTTER = -3, -2, -1
"""Last columns of the posterior, behind one column a track."""


@dataclass(frozen=True, eq=False)
class Share:
    """Points of a track: its ``claim``, with their ``posterior`` (M,).

    ``isolated``: alone in its component; ``alone``: how many points it would have without other
    tracks; ``near_other`` (M,): close to another mover; ``beside``: moving points near the model of
    no track, which are other movers from now on.
    """

    claim: Claim
    posterior: F64
    isolated: bool
    alone: int
    near_other: Mask
    beside: I64


@dataclass(frozen=True, eq=False)
class Labelling:
    """Labels of a frame: the ``shares`` of the tracks."""

    shares: Mapping[int, Share] = field(default_factory=dict)

    def taken(self, count: int, but: int = -1) -> Mask:
        """Return a mask (N,) of the points of all tracks except one."""
        mask = np.zeros(count, np.bool_)
        for label, share in self.shares.items():
            if label != but:
                mask[share.claim.indices] = True
        return mask


@dataclass(frozen=True, eq=False)
class Near:
    """Evidence at the points (M,) of a track's window, in metres and nats; no prior changes it.

    ``gap``: distance to the model; ``cost``: the same in place and colour; ``sure``: whether the
    model is well confirmed there; ``carved``: earlier views looked through; ``ratio``: log ratio of
    colours; ``rest`` and ``along``: distance to other movers where they were, and carried along.
    """

    cost: F64
    gap: F64
    nearest: I64
    sure: Mask
    carved: Mask
    ratio: F64
    rest: F64
    along: F64
    radius: float
    extent_known: bool

    def known(self, priors: Priors, reach: float) -> F64:
        """Return the energy (M,) of being on the known surface."""
        sigma = priors.known_reaches * reach
        inside = np.isfinite(self.gap)
        colour = np.zeros(len(self.gap))
        colour[inside] = self.cost[inside] ** 2 - self.gap[inside] ** 2
        colour = np.minimum(0.5 * np.maximum(colour, 0.0) / sigma**2, priors.unlike_nats)
        place = 0.5 * (self.gap / sigma) ** 2
        return np.asarray(
            place + colour + priors.unsure_nats * ~self.sure + priors.carved_nats * self.carved
        )

    def new(self, priors: Priors) -> F64:
        """Return the energy (M,) of being new surface."""
        grown = priors.growth_nats * self.gap / self.radius
        if not self.extent_known:
            grown = np.minimum(grown, priors.growth_cap_nats)
        far = priors.new_nats + grown
        return np.asarray(far + priors.carved_nats * self.carved - priors.colour_nats * self.ratio)


def label(
    tracks: Mapping[int, Track],
    fits: dict[int, Registration],
    view: View,
    background: Background,
    free: Mask,
    options: NextOptions,
) -> Labelling:
    """Return the labels that minimise the energy around the registered tracks."""
    found = {n: tracks[n] for n in sorted(fits)}
    support = support_of(found.values(), fits, view, background, free, options.energy)
    if not len(support.index):
        return Labelling()
    near = {n: _nearness(track, fits[n], support, options.energy) for n, track in found.items()}
    cost, posterior, foreign = decided(support, near, found, options)
    return _shares(support, near, found, fits, cost, posterior, foreign, options)


def decided(
    support: Support, near: Mapping[int, Near], tracks: Mapping[int, Track], options: NextOptions
) -> tuple[F64, F64, Mask]:
    """Return the energy and the posterior (S, K + 3) of each node.

    The third marks the nodes (S,) that are evidence of another mover if no track gets them.
    """
    energy, priors = options.energy, options.priors["held"]
    cost = np.full((len(support.index), len(near) + 3), energy.blocked_nats)
    on_known = np.zeros(len(support.index), np.bool_)
    for column, (n, each) in enumerate(near.items()):
        window, own = support.windows[n], options.priors[tracks[n].kind]
        known = each.known(own, tracks[n].reach)
        on = (known < own.on_known_nats) & window.may
        on_known[window.nodes[on]] = True
        new = np.where(_touched(support, window, on), each.new(own), energy.blocked_nats)
        best = np.minimum(known, new) + own.still_nats * ~window.may
        cost[window.nodes, column] = np.where(np.isfinite(each.gap), best, energy.blocked_nats)
    like, behind, _ = support.neighbours
    cost[:, CLUTTER] = (
        priors.clutter_nats
        + priors.clutter_neighbour_nats * np.maximum(0, like - 1)
        + 0.5 * energy.cap_nats * ~behind
    )
    cost[:, OTHER], foreign = _other_energy(support, near, tracks, on_known, options)
    cost[:, BACKGROUND] = support.background
    return cost, _posterior(support, cost, energy), foreign


def _touched(support: Support, window: Window, on: Mask) -> Mask:
    """Mark the nodes of a window (M,) in a component with known surface of the track, ``on``."""
    part = support.whole[window.nodes]
    held = np.bincount(part[on & (part >= 0)], minlength=len(support.index) + 1)
    return np.asarray((part >= 0) & (held[part] >= support.energy.touching_points))


def _posterior(support: Support, cost: F64, energy: EnergyOptions) -> F64:
    """Return the posterior (S, K + 3) by mean field over the nodes that a track may win."""
    count = cost.shape[1] + OTHER
    gap = cost[:, :count].min(axis=1) - cost[:, count:].min(axis=1)
    posterior = np.zeros_like(cost)
    posterior[np.arange(len(cost)), cost.argmin(axis=1)] = 1.0
    active, paths = support.around(gap < energy.open_gap_nats)
    if len(active):
        posterior[active] = agreed(
            cost[active], paths, energy.sweeps, 0.02, 0.002, 8.0 * energy.pair_nats, 8.0
        )
    return posterior


def _nearness(track: Track, fit: Registration, support: Support, energy: EnergyOptions) -> Near:
    view, window = support.view, support.windows[track.label]
    index = support.index[window.nodes]
    unknown = 0.0 if track.extent_known else energy.unknown_units * track.unit
    radius = max(track.model.radius, unknown)
    count = len(index)
    cost, gap, nearest = np.full(count, np.inf), np.full(count, np.inf), np.full(count, -1)
    rough = track.model.xyz[:: max(1, len(track.model.xyz) // energy.rough_points)]
    xyz = view.xyz[index].astype(np.float64)
    world = transform(fit.pose, rough)
    target = Target(world, np.empty((0, 3), np.float32), 0.0)
    far, at = target.nearest(xyz, support.colour[:0], energy.far_radii * radius)
    some = at >= 0
    step = max(1, len(track.model.xyz) // energy.rough_points)
    gap[some], cost[some], nearest[some] = far[some], far[some], at[some] * step
    close = energy.close_reaches * track.reach
    claimed = claim(view, index, fit.world, track.model.colour, track.weight, close)
    exact = np.searchsorted(index, claimed.indices)
    cost[exact], gap[exact], nearest[exact] = claimed.cost, claimed.gap, claimed.nearest
    colour = support.colour[window.nodes]
    sure = track.model.hits[nearest] >= track.options.surface.sure_hits
    was_carved = np.zeros(count, np.bool_)
    if fit.cost <= track.options.claim.sharp_cost and not track.soft:
        loose = np.flatnonzero(np.isfinite(gap) & ~(sure & (gap < 0.9 * track.reach)))
        was_carved[loose] = carved(list(track.views), view, fit.pose, index[loose], track.unit)
    half = 0.5 * energy.cap_nats
    ratio = np.clip(track.log_ratio(colour).astype(np.float64), -half, half)
    rest, along = _from_others(track, fit, xyz, colour)
    return Near(
        cost, gap, nearest, sure, was_carved, ratio, rest, along, radius, track.extent_known
    )


def _from_others(track: Track, fit: Registration, xyz: F64, colour: np.ndarray) -> tuple[F64, F64]:
    """Return distances (M,) to the other movers where they were, and where they went along."""
    far = track.options.context.stayed_units * track.unit
    if not len(track.others.xyz):
        return np.full(len(xyz), np.inf), np.full(len(xyz), np.inf)
    target = track.others.target
    rest, at = target.nearest(xyz, colour, far)
    rest = np.where(at < 0, np.inf, rest)
    last, ends = track.motion.poses[-1], track.ends
    moved = np.abs(transform(fit.pose, ends) - transform(last, ends)).max()
    if moved < track.options.context.rest_units * track.unit:
        return rest, rest
    back = inverse(fit.pose @ inverse(last))
    along, at = target.nearest(transform(back, xyz), colour, far)
    return rest, np.where(at < 0, np.inf, along)


def _other_energy(
    support: Support,
    near: Mapping[int, Near],
    tracks: Mapping[int, Track],
    on_known: Mask,
    options: NextOptions,
) -> tuple[F64, Mask]:
    """Return (S,) the energy of being another mover, and where that is evidence for later."""
    energy, priors = options.energy, options.priors["held"]
    count = len(support.index)
    surface, there = np.full(count, np.inf), np.zeros(count, np.bool_)
    for n, each in near.items():
        track, nodes = tracks[n], support.windows[n].nodes
        distance = np.minimum(each.rest, each.along)
        at = priors.other_nats + 0.5 * (distance / (priors.other_reaches * track.reach)) ** 2
        wide = 0.5 * (distance / (priors.other_near_reaches * track.reach)) ** 2
        beside = priors.other_nats + priors.other_near_nats + wide
        beside[on_known[nodes]] = np.inf
        surface[nodes] = np.minimum(surface[nodes], np.minimum(at, beside))
        there[nodes] |= np.isfinite(each.rest)
    surface[support.still] = np.minimum(surface[support.still], priors.other_nats)
    open_, fast, closed, was_there = _components(support, near, tracks, on_known, there, options)
    whole = np.where(fast, priors.closed_nats, priors.closed_slow_nats)
    birth = np.where(open_, np.where(closed, priors.pocket_nats, priors.open_nats), whole)
    stayed = 1.0 / (1.0 + np.exp((priors.was_there_share - was_there) / 0.07))
    birth = np.maximum(birth - priors.was_there_nats * stayed, priors.open_nats)
    # Unknown surface of a closed component was missed before: no other mover explains it.
    alone = ~open_ & fast
    surface = np.where(alone, np.maximum(surface, priors.other_closed_nats), surface)
    off = np.where(alone, birth, np.minimum(surface, birth))
    other = np.minimum(np.where(on_known, surface, off), energy.cap_nats)
    return other, ~alone | (was_there > priors.was_there_share)


def _components(
    support: Support,
    near: Mapping[int, Near],
    tracks: Mapping[int, Track],
    on_known: Mask,
    there: Mask,
    options: NextOptions,
) -> tuple[Mask, Mask, Mask, F64]:
    """Return the kind of the component of each node (S,).

    Masks: open; with a track that moves and touches no scenery; in a part beside known surface
    that is closed.  The last is the share of the part that was there in the last frame.
    """
    energy = options.energy
    size = np.zeros(len(support.index))
    for n, each in near.items():
        track, window = tracks[n], support.windows[n]
        close = window.nodes[each.gap < 4.0 * track.reach]
        most = energy.open_sizes * track.size + 10.0 if track.slow else np.inf
        size[close] = np.maximum(size[close], most)
    open_, fast = _is_open(support, support.moving, size, on_known)
    unexplained = support.moving & ~on_known
    part = support.components(unexplained)
    open_part, _ = _is_open(support, unexplained, size, on_known)
    share = np.zeros(len(size))
    inside = part >= 0
    if inside.any():
        stayed = np.bincount(part[inside], weights=there[inside]) / np.bincount(part[inside])
        share[inside] = stayed[part[inside]]
    return open_, fast, ~open_part, share


def _is_open(support: Support, some: Mask, most: F64, on_known: Mask) -> tuple[Mask, Mask]:
    """Mark the nodes (S,) whose component among ``some`` goes on, or has too many points.

    The second marks components without a limit of points, as a track in them moves, that touch
    no scenery.
    """
    part = support.whole if some is support.moving else support.components(some)
    inside = part >= 0
    open_, fast = np.ones(len(part), np.bool_), np.zeros(len(part), np.bool_)
    if not inside.any():
        return open_, fast
    of = part[inside]
    edge = np.bincount(of, weights=support.edge[inside]) > 0
    count = np.bincount(of, weights=~on_known[inside])
    limit = np.zeros(len(count))
    np.maximum.at(limit, of, most[inside])
    # A component beside no track has no size to compare with: it is its own mover.
    open_[inside] = (edge | (count > limit))[of]
    scenery = np.bincount(of, weights=support.goes_on[inside]) > 0
    fast[inside] = (np.isinf(limit) & ~scenery)[of]
    return open_, fast


def _shares(
    support: Support,
    near: Mapping[int, Near],
    tracks: Mapping[int, Track],
    fits: Mapping[int, Registration],
    cost: F64,
    posterior: F64,
    foreign: Mask,
    options: NextOptions,
) -> Labelling:
    energy = options.energy
    best = posterior.argmax(axis=1)
    labels = list(near)
    whole = support.whole
    unowned = support.moving & foreign & (best >= len(labels))
    others = cost[:, len(labels) :].min(axis=1)
    sure_other = posterior[:, len(labels)] > 0.5
    shares = {}
    for column, n in enumerate(labels):
        track, window, each = tracks[n], support.windows[n], near[n]
        mine = (best[window.nodes] == column) & (each.nearest >= 0)
        nodes = window.nodes[mine]
        wanted = (best[window.nodes] != column) & (
            each.gap < track.options.claim.reaches * track.reach
        )
        wanted &= cost[window.nodes, column] < others[window.nodes]
        found = Claim(
            support.index[nodes],
            each.cost[mine].astype(np.float32),
            each.gap[mine],
            each.nearest[mine],
        )
        lo, hi = fits[n].box
        index = support.index[window.nodes]
        inside = ((support.view.xyz[index] >= lo) & (support.view.xyz[index] <= hi)).all(axis=1)
        neutral = (each.gap < energy.neutral_reaches * track.reach) & ~(
            np.minimum(each.rest, each.along) < track.options.context.explained_units * track.unit
        )
        neutral |= each.gap < track.options.claim.reaches * track.reach
        is_beside = unowned[window.nodes] & inside & ~neutral & ~support.still[window.nodes]
        shares[n] = Share(
            found,
            posterior[nodes, column],
            _is_isolated(support, whole, nodes, best, column, len(labels), energy.isolated_share),
            len(nodes) + int(np.count_nonzero(wanted & (best[window.nodes] < len(labels)))),
            _close(track, support, nodes, sure_other, energy.learn_reaches),
            index[is_beside],
        )
    return Labelling(shares)


def _is_isolated(
    support: Support, whole: I64, nodes: I64, best: I64, column: int, count: int, most: float
) -> bool:
    """Return whether nearly all points of the components of a track's nodes are the track's."""
    of = whole[nodes]
    of = of[of >= 0]
    if not len(of):
        return False
    main = np.bincount(of, minlength=whole.max() + 1) > 0.02 * len(of)
    inside = (whole >= 0) & main[whole]
    foreign = inside & (best != column) & (best <= count)
    return bool(
        np.count_nonzero(foreign) <= most * len(nodes) and not (support.goes_on & inside).any()
    )


def _close(track: Track, support: Support, nodes: I64, others: Mask, reaches: float) -> Mask:
    """Mark the nodes (M,) within some reaches of another mover."""
    there = support.index[others & support.moving]
    if not len(there) or not len(nodes):
        return np.zeros(len(nodes), np.bool_)
    xyz = support.view.xyz
    return close_to(
        xyz[support.index[nodes]].astype(np.float64),
        xyz[there].astype(np.float64),
        reaches * track.reach,
    )
