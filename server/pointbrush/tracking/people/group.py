"""Joint tracking of people."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pointbrush.tracking.compute.grid import bounds, close_to, within
from pointbrush.tracking.interface import F64, I64, USUAL_FPS, Mask, TrackOptions, TrackState
from pointbrush.tracking.model.track import Carrier, Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.people.arrivals import (
    confusable_people,
    merge_newcomers,
    newcomers,
    restore_exchanged_people,
    return_missing_people,
    rules_out,
)
from pointbrush.tracking.people.foreground import Foreground
from pointbrush.tracking.people.observation import PersonObservation
from pointbrush.tracking.people.person import Person, PersonEvidence
from pointbrush.tracking.people.stature import across, ratio, upright
from pointbrush.tracking.people.strides import Shares, shared_out, strides
from pointbrush.tracking.scene.depth import Background, PictureBackground
from pointbrush.tracking.sensors.view import View
from pointbrush.tracking.steps.settle import Outcome


@dataclass(eq=False)
class Group:
    """All people in sight, in cells of ``size`` metres.

    ``unit``: tolerance (m); ``flat`` (3, 2): axes along the ground; ``up`` (3,): vertical axis;
    ``usual``: usual number of cells of a person; ``fps``: frames per second.
    """

    options: TrackerOptions
    people: list[Person]
    size: float
    unit: float
    flat: F64
    up: F64
    usual: float
    now: int = 0
    fps: float = USUAL_FPS

    @staticmethod
    def of(
        view: View, tracks: Mapping[int, Track], background: PictureBackground, fps: float
    ) -> Group:
        """Return the painted people ``tracks`` of a first frame and unlabelled people in it."""
        sizes = [cell_size(view, track, background) for track in tracks.values()]
        people = {label: view.xyz[view.labels[label]].astype(np.float64) for label in tracks}
        unit = float(np.median([track.unit for track in tracks.values()]))
        flat = across(view, people.values())
        up = upright(view, flat)
        group = Group(view.options, [], float(np.median(sizes)), unit, flat, up, 0.0, fps=fps)
        observation = group._sight(view, background, np.ones(len(view.xyz), np.bool_))
        for label, track in tracks.items():
            group.put(view, label, track)
            inside = np.isin(observation.cells.indices, view.labels[label])
            observation.owner[np.unique(observation.cells.cell[inside])] = label
        for person in group.people:
            cells = observation.cells_of(person.label)
            person.area, person.spread = observation.area(cells), observation.spread(cells)
            person.measure(person.top(observation))
        group.usual = float(np.median([person.size for person in group.people]))
        group.people += newcomers(observation, group.people, group.usual, 0)
        return group

    @property
    def labels(self) -> set[int]:
        """Labels of the people that were painted."""
        return {person.label for person in self.people if person.named}

    def _sight(self, view: View, background: PictureBackground, free: Mask) -> PersonObservation:
        return PersonObservation.of(
            view, background, free, self.size, self.unit, self.flat, self.up, self.fps
        )

    def put(self, view: View, label: int, track: Track) -> None:
        """Start a person from their painted points, and replace their former state."""
        if not len(view.labels[label]):
            return
        cells = Foreground.of(view, view.labels[label], self.size)
        person = Person.first_seen(
            self.options, label, cells.middle, cells.colour, self.now, track.appearance
        )
        person.identity.with_flying = track.painted.with_flying
        person.displacement = track.motion.poses[-1][:3, 3]
        if view.frame.rgb is not None:
            points = view.labels[label]
            person.identity.colours = view.colour(
                points[:: max(1, len(points) // self.options.body.colour_points)]
            )
            person.identity.shown = float((view.cells[1][points] ** 2).sum())
        self.drop(label)
        self.people = sorted([*self.people, person], key=lambda f: -f.label)

    def drop(self, label: int) -> None:
        """Remove a person from the search, and from other people's doubts."""
        self.people = [f for f in self.people if f.label != label]
        for person in self.people:
            person.identity.doubts.discard(label)

    def step(self, view: View, background: PictureBackground, free: Mask) -> dict[int, Outcome]:
        """Assign the ``free`` points (N,) of the next frame; return state and points by label."""
        self.now += 1
        self.leave_behind(background)
        observation = self._sight(view, background, free)
        people = self.people
        shares = None
        if len(observation.owner) and people:
            shares = shared_out(observation, people, strides(observation, people))
            removed = return_missing_people(observation, people, self.usual, self.now)
            added = newcomers(observation, people, self.usual, self.now)
            removed |= merge_newcomers(observation, [*people, *added], self.now)
            self.people = [f for f in [*people, *added] if f.label not in removed]
            restore_exchanged_people(observation, self.people, self.now)
        expected = {f.label: np.median((f.xyz + f.step) @ self.flat, axis=0) for f in people}
        found = {}
        for k, person in enumerate(people):
            stride = person.step if shares is None else shares.stride[k]
            evidence = _evidence(observation, person, shares, k, stride, expected)
            if evidence is not None and person.named:
                self.doubt(observation, person, evidence)
            person.follow(observation, stride, self.now)
            if person.named:
                found[person.label] = outcome(observation, person, evidence)
            else:
                person.measure(person.top(observation))
        left = any(f.named and f.at_side and f.frames_unseen for f in people)
        for person in (f for f in self.people if left and not f.named and f.since):
            if len(person.seen) < self.options.smoothing.lag_frames:
                person.seen[view.number] = observation.points_of(person.label)
        self.people = [
            f
            for f in self.people
            if f.named or f.frames_unseen < self.options.body.forgotten_frames
        ]
        return found

    def leave_behind(self, background: PictureBackground) -> None:
        """Add static surface with a person's label to the background after they walked on."""
        for person in (f for f in self.people if f.named):
            departure = person.departure()
            if departure is not None:
                background.left_behind(person.label, *departure)

    def doubt(
        self, observation: PersonObservation, person: Person, evidence: PersonEvidence
    ) -> None:
        """Record identity doubts of a person, until clothes or stature resolve them.

        A person is doubted if they reappear, or are suddenly much larger, where another person may
        be, or while their stature equals that of another.
        """
        options = self.options
        identity = person.identity
        others = confusable_people(observation, self.people, person, self.now)
        most = options.body.crowded_ratio * max(identity.first, self.usual)
        if person.last_clear < self.now - 1 or evidence.size * person.size > most:
            for other in others:
                person.doubt(other)
        top = person.top(observation)
        doubted = [f for f in self.people if f.label in identity.doubts and f not in others]
        doubted = doubted if evidence.like > -options.body.clearly_log else []
        as_tall = [f for f in self.people if f.named and f is not person]
        as_tall = [
            f
            for f in as_tall
            if ratio(top, f.identity.stature, identity.stature) >= options.stature.decisive_log_odds
        ]
        some = observation.some(observation.cells_of(person.label)) if doubted or as_tall else None
        identity.doubts -= {f.label for f in doubted if rules_out(some, top, person, f)}
        identity.doubts |= {f.label for f in as_tall if rules_out(some, top, f, person)}
        if (
            not identity.doubts
            and evidence.likelihood(options=self.options) > options.body.sure_likelihood
        ):
            identity.sure = self.now
            person.measure(top)
            update_clothing(observation, person, evidence)


def update_clothing(
    observation: PersonObservation, person: Person, evidence: PersonEvidence
) -> None:
    """Update the histogram of a person's clothes if much more of them is visible than before.

    Example: a person painted behind another one.  Their cells must not touch other people's.
    """
    options = observation.options.body
    cells = observation.cells_of(person.label)
    some, area = observation.some(cells), observation.area(cells)
    identity = person.identity
    if (
        some is not None
        and evidence.touching < options.touching_share
        and area > options.better_ratio * identity.shown > 0.0
    ):
        identity.show(some, area)


def cell_size(view: View, track: Track, background: PictureBackground) -> float:
    """Return the size (m) of a cell that is fine enough for a person."""
    options = view.options.body
    noise = float(np.median(background.noise(view.cells[1][view.labels[track.label]])))
    calm = min(options.cell_sigmas * noise, options.limb_share * track.span)
    return max(options.cell_units * track.unit, options.cell_radius_share * track.span, calm)


def _evidence(
    observation: PersonObservation,
    person: Person,
    shares: Shares | None,
    k: int,
    stride: F64,
    expected: Mapping[int, F64],
) -> PersonEvidence | None:
    """Gather the evidence of a person's share of a frame; None where they have none."""
    cells = np.flatnonzero((observation.owner == person.label) & observation.cells.solid)
    if shares is None or not len(cells):
        return None
    return PersonEvidence(
        fit=float(np.minimum(shares.cost[cells, k], observation.options.step.cap).mean()),
        disputed=shares.disputed(cells, k, options=observation.view.options.step),
        size=len(cells) / max(person.size, 1.0),
        change=len(cells) / max(person.last, 1),
        shown=float(observation.shows(person.xyz + stride).mean()),
        like=person.likeness(observation.some(cells)),
        back=person.frames_unseen > 0,
        touching=observation.touching_others(cells, person.label),
        wider=max(
            0.0, observation.spread(cells) - max(observation.options.body.spread_m, person.spread)
        ),
        astray=astray(observation, person.label, cells, expected),
    )


def astray(
    observation: PersonObservation, label: int, cells: I64, expected: Mapping[int, F64]
) -> float:
    """Return a log ratio of ground distances of ``cells`` (C,) from ``expected`` positions (2,).

    It compares the person's own position with the nearest position of another person.
    """
    options = observation.options.body
    middle = np.median(observation.ground[cells], axis=0)
    distance = {k: float(np.linalg.norm(at - middle)) for k, at in expected.items()}
    own = distance.pop(label)
    other = min(distance.values(), default=options.nearest_m[1])
    return float(np.log(max(own, options.nearest_m[0]) / np.clip(other, *options.nearest_m)))


def outcome(
    observation: PersonObservation, person: Person, evidence: PersonEvidence | None
) -> Outcome:
    """Return the state of a person in the frame, and their points."""
    options = observation.options
    identity, pose = person.identity, np.eye(4)
    pose[:3, 3] = person.displacement
    points = observation.points_of(person.label)
    if identity.with_flying:
        points = np.concatenate([points, observation.take_flying(points)])
    points = np.sort(points)
    if person.frames_unseen or evidence is None:
        # The visible points are theirs, but too few to track.
        identity.confidence = max(0.0, identity.confidence - options.confidence.regain)
        lost = person.frames_unseen > options.update.lost_frames
        state = TrackState(pose, 0.0, 0.0, 0.0, 0, "lost" if lost else "occluded")
        return Outcome(state, points)
    identity.confidence = min(
        evidence.likelihood(options=observation.view.options),
        identity.confidence + options.confidence.regain,
    )
    cap = options.body.doubted_confidence if identity.doubts else 1.0
    identity.confidence = min(identity.confidence, identity.cap, cap)
    state = TrackState(pose, 0.0, evidence.shown, identity.confidence, len(points), "tracked")
    return Outcome(state, points)


class JointTracking:
    """People among the ``tracks`` of a run, for a depth camera at rest or a mapped scene.

    Objects that they carry or pass are tracked separately and first; people share the remaining
    points.  Tracks too sparse to resolve limbs are not tracked jointly.
    """

    def __init__(
        self, tracks: Mapping[int, Track], options: TrackerOptions, track_options: TrackOptions
    ) -> None:
        """``tracks``: live mapping of all tracks of the run."""
        self._tracks, self._track_options, self.options = tracks, track_options, options
        self.group: Group | None = None

    @property
    def labels(self) -> set[int]:
        """Labels of jointly tracked people."""
        return set() if self.group is None else self.group.labels

    def __contains__(self, label: int) -> bool:
        """Return whether a label is tracked jointly with others."""
        return label in self.labels

    def gather(self, view: View, background: Background, labels: Iterable[int]) -> None:
        """Start joint tracking of the people among the ``labels`` of a frame, if it applies."""
        bodies = {n: self._tracks[n] for n in labels if self._shows_limbs(self._tracks[n])}
        if bodies and isinstance(background, PictureBackground):
            self.group = Group.of(view, bodies, background, self._track_options.fps)
            self._share_clothing()

    def join(self, view: View, background: Background, label: int) -> None:
        """Add a person painted in the middle of a run to the group."""
        if self.group is None:
            self.gather(view, background, [label])
        elif self._shows_limbs(self._tracks[label]):
            self.group.put(view, label, self._tracks[label])
        self._share_clothing()

    @property
    def pending(self) -> set[int]:
        """Frames with newcomers who may be recognised in later frames."""
        people = () if self.group is None else self.group.people
        return {number for f in people if not f.named for number in f.seen}

    def pop_recognised(self) -> dict[int, tuple[dict[int, I64], float]]:
        """Return points by frame, and a confidence, of people just recognised, by label."""
        people = () if self.group is None else self.group.people
        found = [f for f in people if f.named and f.seen]
        earlier = {f.label: (f.seen, f.identity.cap) for f in found}
        for person in found:
            person.seen = {}
        return earlier

    def _share_clothing(self) -> None:
        """Give the people's colour histograms to all other tracks."""
        labels = sorted(self.labels)
        clothes = tuple(self._tracks[n].appearance for n in labels)
        for track in (t for n, t in self._tracks.items() if n not in labels):
            track.clothes = clothes

    def _shows_limbs(self, track: Track) -> bool:
        """Return whether a track is a person dense enough to resolve limbs."""
        return track.body and track.unit < self.options.body.limb_m

    def update_carriers(self, view: View, outcomes: dict[int, Outcome]) -> None:
        """Update the carrier of each small object, and move occluded objects along with theirs.

        An object that has left its place and touches a person is carried.  If it is not found and
        the carrier has few points, these may include the object: the carrier's confidence is
        reduced.
        """
        if self.group is None:
            return
        flat = self.group.flat
        middle = {f.label: np.median(f.xyz @ flat, axis=0) for f in self.group.people if f.named}
        for label in sorted(outcomes.keys() - middle.keys()):
            track, one = self._tracks[label], outcomes[label]
            place, carrier = track.motion.place @ flat, track.carrier
            if one.state.state == "tracked":
                carrier_label = self._touching(view, track, one.points, outcomes)
                if (
                    carrier_label
                    and track.has_left_start
                    and track.confidence >= self.options.smoothing.sure
                ):
                    track.carrier = Carrier(carrier_label, place - middle[carrier_label])
            elif carrier is not None and carrier.label in middle:
                step = flat @ (middle[carrier.label] + carrier.offset - place)
                track.motion = track.motion.go_along(step)
                if carrier.label in outcomes:
                    outcomes[carrier.label] = self._doubted(outcomes[carrier.label], track.size)

    def _doubted(self, bearer: Outcome, size: float) -> Outcome:
        """Return a person's outcome if ``size`` of their points may be a carried object's."""
        options = self.options.body
        if size <= options.carried_size_share * len(bearer.points):
            return bearer
        trust = min(bearer.state.confidence, options.doubted_confidence)
        return replace(bearer, state=replace(bearer.state, confidence=trust))

    def _touching(
        self, view: View, track: Track, points: I64, outcomes: Mapping[int, Outcome]
    ) -> int:
        """Return the label of the person with the most points touching an object's; 0: none."""
        xyz, reach = view.xyz[points], self.options.claim.touching_units * track.unit
        lo, hi = bounds(xyz)
        best, most = 0, 0
        for label in outcomes.keys() & self.labels:
            theirs = view.xyz[outcomes[label].points]
            theirs = theirs[within(theirs, lo - reach, hi + reach)]
            count = int(close_to(theirs, xyz, reach).sum()) if len(theirs) else 0
            best, most = (label, count) if count > most else (best, most)
        return best

    def step(
        self, view: View, background: Background, free: Mask, painted: Mapping[int, I64]
    ) -> dict[int, Outcome]:
        """Return outcomes by label of the people in the next frame, except ``painted`` ones.

        ``free`` (N,): points that they may have.
        """
        if self.group is None or not isinstance(background, PictureBackground):
            return {}
        found = self.group.step(view, background, free)
        for label, one in found.items():
            track = self._tracks[label]
            track.lost = one.state.state == "lost" and not self._track_options.continue_lost
            if track.lost:
                self.group.drop(label)
        return {label: each for label, each in found.items() if label not in painted}
