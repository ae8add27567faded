"""Assign connected foreground bodies to people, also after an occlusion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from pointbrush.tracking.compute.grid import close_to, perhaps_near
from pointbrush.tracking.compute.rigid import transform
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.model.registration import Registration, no_points
from pointbrush.tracking.model.track import OtherMovers, Track, begin
from pointbrush.tracking.options.people import BodyOptions
from pointbrush.tracking.options.sensors import BackgroundOptions
from pointbrush.tracking.people.foreground import OTHER, Foreground
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.association import Associations, LabelledPoints
from pointbrush.tracking.steps.claim import Claim
from pointbrush.tracking.steps.context import step_of


def reappearing_points(view: View, tracks: Mapping[int, Track], moving: I64) -> dict[int, I64]:
    """Return the points by label of large ``tracks`` that reappear from behind other objects.

    ``moving``: unexplained foreground points.  Each connected body is assigned to the object with
    the most similar colours, in descending order of likelihood.  The body must be within reach of
    the expected position and share colours with the object.  A track without a match is left out.
    """
    options = view.options
    if len(moving) < options.claim.min_claim_points or not tracks:
        return {}
    foreground = Foreground.of(view, moving, _cell_size(tracks.values(), options.body))
    bodies = foreground.bodies(2 * options.body.min_part_cells)
    offers = [
        (like, label, number, points)
        for label, track in tracks.items()
        for like, number, points in _alike_bodies(view, track, foreground, bodies)
    ]
    found: dict[int, I64] = {}
    assigned: set[int] = set()
    for _, label, number, points in sorted(offers, key=lambda o: (-o[0], o[1], o[2])):
        if label not in found and number not in assigned:
            found[label] = points
            assigned.add(number)
    return found


def entering_bodies(
    tracks: Mapping[int, Track], associations: Associations, labelled: Mapping[int, LabelledPoints]
) -> dict[int, I64]:
    """Return by label the bodies of people painted only in a small part at an edge.

    The painted object is judged again, with the surface connected to it that is visible now.
    """
    view, found = associations.view, dict[int, I64]()
    options = view.options
    new = [n for n in labelled if _may_be_entering(tracks[n])]
    moving = np.flatnonzero(associations.unclaimed(but=new)) if new else no_points()
    moving = moving[associations.background.certain(view, moving)]
    for label in new:
        track, own = tracks[label], labelled[label].points
        foreground = Foreground.of(view, moving, _cell_size([track], options.body))
        for cells in foreground.bodies(options.body.min_part_cells):
            points = foreground.indices[np.isin(foreground.cell, cells)]
            if np.isin(own, points).sum() > options.body.majority_share * len(own):
                body = begin(view, label, points, track.unit, OtherMovers.none())
                found |= {label: points} if body.large else {}
    return found


def _may_be_entering(track: Track) -> bool:
    """Return whether a small object was painted at an edge of the picture in the last frames."""
    recent = len(track.motion.poses) <= track.options.track.entering_frames
    return track.painted.entering and recent and not track.large


def _cell_size(tracks: Iterable[Track], options: BodyOptions) -> float:
    """Return the median size (m) of a foreground cell over large ``tracks``."""
    return float(
        np.median(
            [max(options.cell_units * t.unit, options.cell_radius_share * t.span) for t in tracks]
        )
    )


def _alike_bodies(
    view: View, track: Track, foreground: Foreground, bodies: Sequence[I64]
) -> Iterator[tuple[float, int, I64]]:
    """Yield the bodies within reach of a track, alike in colour: log likelihood, number, points."""
    options = view.options
    # A person may have turned back outside the picture.
    either = (track.motion.predictions[0], track.motion.poses[-1])
    expected = np.vstack([transform(T, track.model.xyz) for T in either])
    distance, _ = cKDTree(expected).query(foreground.middle)
    reach = track.span * (
        options.arrivals.return_radii
        + options.arrivals.return_radii_per_frame
        * min(track.frames_unseen, options.search.max_growing_frames)
    )
    least = options.track.hardly_share * options.arrivals.return_scrap_share * track.size
    for number, cells in enumerate(bodies):
        gap = float(np.asarray(distance)[cells].min())
        if gap > reach:
            continue
        points = foreground.indices[np.isin(foreground.cell, cells)]
        if len(points) < least:
            continue
        colour = view.colour(points[:: _step(len(points), options=options.body)])
        if track.appearance.share(colour) > options.appearance.alike_share:
            edge = options.arrivals.return_edge_cost * gap / reach
            yield track.appearance.likeness(colour) - edge, number, points


def has_own_colours(label: int, tracks: Mapping[int, Track], view: View, points: I64) -> bool:
    """Return whether the colours of ``points`` fit an object, and fit it better than others."""
    options = view.options
    colour = view.colour(points[:: _step(len(points), options=options.body)])
    appearance = tracks[label].appearance
    others = [t.appearance.likeness(colour) for n, t in tracks.items() if n != label and t.large]
    alike = appearance.share(colour) > options.appearance.alike_share
    least = max(others, default=-np.inf) - options.arrivals.return_log
    return alike and appearance.likeness(colour) > least


def _step(count: int, options: BodyOptions) -> int:
    return max(1, count // options.colour_points)


def undisputed(
    claims: Mapping[int, Claim], tracks: Mapping[int, Track], options: BodyOptions
) -> dict[int, Claim]:
    """Return the claims, with a body claimed by two large objects given to the likelier one.

    Resolved point by point, an occluded object would take points of the object in front of it.
    """
    result = dict(claims)
    large = [n for n in claims if tracks[n].large]
    for one, other in combinations(large, 2):
        a, b = result[one], result[other]
        _, i, j = np.intersect1d(a.indices, b.indices, assume_unique=True, return_indices=True)
        if len(i) <= options.disputed_share * min(len(a.indices), len(b.indices)):
            continue
        cost = float(a.cost[i].mean()) / tracks[one].reach
        against = float(b.cost[j].mean()) / tracks[other].reach
        loser, disputed = (other, j) if cost <= against else (one, i)
        keep = np.ones(len(result[loser].indices), np.bool_)
        keep[disputed] = False
        result[loser] = result[loser].pick(keep)
    return result


def keep_connected(
    tracks: Mapping[int, Track],
    associations: Associations,
    labelled: Mapping[int, LabelledPoints],
    taken: Mask,
) -> dict[int, LabelledPoints]:
    """Return the points of large objects connected to their claims; claims may lose points.

    ``taken`` (N,): points that people already have.  Static points and points at the former place
    of unlabelled objects are seeds of the outside and spread as well: floor that a foot has just
    uncovered is connected to the floor around it.
    """
    view, background = associations.view, associations.background
    options = view.options
    cores = {
        n: found.claim.indices
        for n, found in labelled.items()
        if tracks[n].large and len(found.claim.indices) >= options.claim.min_claim_points
    }
    if not cores:
        return {}
    size = _cell_size([tracks[n] for n in cores], options.body)
    inside, ground = _before_and_behind(associations, cores, taken, size)
    other = _others(tracks, associations, cores, np.flatnonzero(inside & ~taken), ground, size)
    either = inside.copy()
    either[ground] = True
    every = np.flatnonzero(either)
    foreground = Foreground.of(view, every, size)
    # Surface that reappears at its depth from before an occlusion keeps its former label.
    former_label = np.where(inside[every], background.reappearing_labels(view, every), 0)
    seeds = _seeds(len(view.xyz), cores, every, former_label, options=options.background)
    sure = (background.certain(view, every) | (former_label != 0)) & inside[every]
    far = {n: options.body.way_radii * tracks[n].span for n in cores} | _by_clothes(
        seeds, sure, foreground, tracks
    )
    clothes = {n: t.appearance for n, t in tracks.items() if t.large and not t.lost}
    spread = foreground.spread(seeds, ~inside[every], other[every], sure, far, clothes)
    movers = np.zeros(len(view.xyz), np.bool_)
    movers[every[spread == OTHER]] = True
    found = {n: _restricted_to(view, labelled[n], every[spread == n]) for n in cores}
    owned = taken.copy()
    for one in found.values():
        owned[one.points] = True
    for label, one in found.items():
        moving = associations.found[label].registration.moving
        beside = moving[movers[moving]]
        found[label] = replace(one, beside=beside, owned=moving[owned[moving]])
    return found


def _before_and_behind(
    associations: Associations, cores: Mapping[int, I64], taken: Mask, size: float
) -> tuple[Mask, I64]:
    """Return a mask (N,) of moving points around large objects and indices (M,) at rest nearby.

    Of the ``taken`` points only the claims ``cores`` count; nearby is within ``size`` metres.
    """
    view = associations.view
    inside, outside = np.zeros(len(view.xyz), np.bool_), np.zeros(len(view.xyz), np.bool_)
    for label in cores:
        fit = associations.found[label].registration
        outside[fit.around] = True
        inside[fit.moving] = True
    inside[taken] = False
    for core in cores.values():
        inside[core] = True
    outside &= ~inside & ~taken
    return inside, _touching_points(view, np.flatnonzero(outside), np.flatnonzero(inside), size)


def _others(
    tracks: Mapping[int, Track],
    associations: Associations,
    cores: Mapping[int, I64],
    rest: I64,
    ground: I64,
    size: float,
) -> Mask:
    """Return a mask (N,) of the moving points ``rest`` (M,) that belong to unlabelled objects."""
    view, other = associations.view, np.zeros(len(associations.view.xyz), np.bool_)
    scene = view.xyz[ground[associations.background.static(view, ground)[0]]]
    for label in cores:
        moved = _movers(
            tracks[label].other_movers, scene, associations.view.options.body.scene_cells * size
        )
        fit = associations.found[label].registration
        other[rest[_explained_points(tracks[label], moved, view, fit, rest)]] = True
    return other


def _seeds(
    count: int, cores: Mapping[int, I64], every: I64, former_label: I64, options: BackgroundOptions
) -> dict[int, Mask]:
    """Return masks by label over the points ``every`` (M,) of ``count`` that are certainly its.

    They are its claim and, if a good part of the claim has reappeared, all points with its label
    in ``former_label`` (M,).
    """
    seeds: dict[int, Mask] = {}
    for label, core in cores.items():
        mask = np.zeros(count, np.bool_)
        mask[core] = True
        seeds[label] = mask[every]
        if np.count_nonzero(former_label[mask[every]] == label) > options.stayed_share * len(core):
            seeds[label] |= former_label == label
    return seeds


def _restricted_to(view: View, found: LabelledPoints, points: I64) -> LabelledPoints:
    """Return an object with ``points`` (M,): its claim restricted to them, and new surface."""
    own = np.zeros(len(view.xyz), np.bool_)
    own[points] = True
    claim = found.claim.pick(own[found.claim.indices])
    own[claim.indices] = False
    return replace(found, claim=claim, grown=np.flatnonzero(own))


def _by_clothes(
    seeds: dict[int, Mask], sure: Mask, foreground: Foreground, tracks: Mapping[int, Track]
) -> dict[int, float]:
    """Reassign points in ``seeds`` with distinct colours of a person expected nearby.

    Changes ``seeds``.  A person without seeds gets some under their negative label, to block
    others.  Returns the longest paths (m) of these by label.
    """
    options, longest = foreground.options.body, foreground.options.search.max_growing_frames
    dressed = {n: t for n, t in tracks.items() if t.large and not t.lost}
    labels = list(dressed)
    if len(labels) < 2:
        return {}
    like = np.stack([t.appearance.each(foreground.colour) for t in dressed.values()])
    first, second = np.sort(like, axis=0)[[-1, -2]]
    best = np.where(first - second > options.distinct_log, like.argmax(axis=0), -1)
    far: dict[int, float] = {}
    for at, label in enumerate(labels):
        track = dressed[label]
        reach = track.span * options.clothes_radii * (1 + min(track.frames_unseen, longest))
        expected = transform(track.motion.predictions[0], track.model.xyz)
        cells = np.flatnonzero(best == at)
        close = np.zeros(len(best), np.bool_)
        close[cells] = close_to(foreground.middle[cells], expected, reach)
        mine = close[foreground.cell] & sure
        if not mine.any():
            continue
        for other, seed in seeds.items():
            if other != label:
                seed &= ~mine
        key = label if label in seeds else -label
        seeds[key] = seeds.get(key, np.zeros(len(sure), np.bool_)) | mine
        far[key] = options.way_radii * track.span
    return far


def _touching_points(view: View, still: I64, moving: I64, size: float) -> I64:
    """Return the points of ``still`` that touch moving ones, by cells of ``size`` metres."""
    some = moving[:: max(1, len(moving) // view.options.body.sampled_points)]
    if not len(some) or not len(still):
        return still[:0]
    return still[perhaps_near(view.xyz[still], view.xyz[some], size)]


def _movers(other_movers: OtherMovers, scene: F32, apart: float) -> OtherMovers:
    """Return the unlabelled points that are not part of the static scene."""
    moving = ~close_to(other_movers.xyz, scene, apart)
    return OtherMovers(other_movers.xyz[moving], other_movers.colour[moving], other_movers.weight)


def _explained_points(
    track: Track, other_movers: OtherMovers, view: View, fit: Registration, rest: I64
) -> Mask:
    """Mark the points explained by an unlabelled mover, at rest or moved along with the object."""
    step = step_of(track, fit)
    reach = np.full(len(rest), 3 * track.unit)
    return other_movers.explain(view.xyz[rest].astype(np.float64), view.colour(rest), reach, step)
