"""Nested candidates for clicks on a frame, cached until one of them is committed.

A click consists of rays into a frame, and the points that can be selected.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import FrameValues, LabelStore
from pointbrush.selection import Points, Stroke, first_hits
from pointbrush.selection.box import clipped
from pointbrush.selection.points import Alive
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import StoredFrame
from pointbrush.work.annotate.painted_frame import Seen, both, frame_points, of_shown_sensors
from pointbrush.work.events import Prepared
from pointbrush.work.objects.choosing import Selectors
from pointbrush.work.objects.options import ObjectOptions
from pointbrush.work.objects.states import States

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]
Version = tuple[str | None, int, int]
"""A frame at a revision: the recording's identity, the frame, the revision of its last change."""


@dataclass(frozen=True, eq=False)
class Clicks:
    """Rays that hit an object (``positives``) and that hit other surfaces (``negatives``).

    Both are ``Stroke`` values with samples in source coordinates, a radius around a ray and a clip
    box that limits the selection.  ``label``: the label to paint; its own points can be selected,
    points of other labels only with ``take_labelled``.  ``hidden``: labels that only this viewer
    hides, ``hidden_sensors``: numbers of such sensors.  ``previous``: the id of the current
    candidate, or "".
    """

    positives: Stroke
    negatives: Stroke
    label: int = 0
    take_labelled: bool = False
    hidden: frozenset[int] = frozenset()
    hidden_sensors: frozenset[int] = frozenset()
    previous: str = ""

    @classmethod
    def parse(cls, fields: Mapping[str, Any], most: int) -> Clicks:
        """Build from the fields of a call or a message; at most ``most`` clicks of either kind.

        Raises BadInputError.
        """
        plain = {"shape": "ray", "tool": "erase"}
        kept = {name: fields[name] for name in ("radius", "clip") if fields.get(name) is not None}
        empty = Stroke.parse({**plain, **kept})
        return cls(
            positives=_clicks(empty, "positives", fields.get("positives") or (), most),
            negatives=_clicks(empty, "negatives", fields.get("negatives") or (), most),
            label=int(fields.get("label") or 0),
            take_labelled=bool(fields.get("take_labelled", False)),
            hidden=frozenset(fields.get("hidden") or ()),
            hidden_sensors=frozenset(fields.get("hidden_sensors") or ()),
            previous=str(fields.get("previous") or ""),
        )

    def cache_key(self) -> tuple[object, ...]:
        """Return a key of these clicks, without ``previous``."""
        rays = (
            array.tobytes()
            for stroke in (self.positives, self.negatives)
            for array in (stroke.origins, stroke.directions)
        )
        radius = self.positives.radius
        clip = self.positives.clip
        box = () if clip is None else tuple(array.tobytes() for array in clip.values.values())
        hidden = sorted(self.hidden), sorted(self.hidden_sensors)
        return *rays, radius, self.label, self.take_labelled, *hidden, box


def _clicks(empty: Stroke, name: str, samples: Sequence[Mapping[str, Any]], most: int) -> Stroke:
    if len(samples) > most:
        raise BadInputError(f"{name}: expected at most {most} clicks, got {len(samples)}")
    return empty.with_samples(samples)


def surface_hits(points: Points, rays: Stroke, shift: Floats, alive: Alive) -> Floats:
    """Intersect rays in source coordinates with the frame: (K, 3) local metres, hits only."""
    local = rays.to_local(shift)
    meets = clipped(local.clip, points, alive)
    hits = first_hits(points, local.origins, local.directions, local.radius, meets)
    return hits[np.isfinite(hits[:, 0])]


@dataclass(frozen=True, eq=False)
class Level:
    """A candidate: ``numbers`` are its points, stored order, ascending.

    ``id`` is opaque and identifies frame, clicks and revision; ``level`` counts from the smallest.
    """

    id: str
    level: int
    score: float
    numbers: Numbers


@dataclass(frozen=True, eq=False)
class Answer:
    """Candidates for clicks, from part to group; ``first`` is the one to show first.

    ``ready``: they are based on the whole frame, not only on points around the clicks.
    """

    candidates: tuple[Level, ...]
    first: int
    ready: bool


class StaleCandidateError(ConflictError):
    """The frame changed since a candidate was offered; ``answer`` has the current candidates."""

    title = "Candidate is stale"

    def __init__(self, answer: Answer) -> None:
        super().__init__(
            "candidate: expected one of the newest answer for these clicks; the frame has changed, "
            "or the id is of other clicks"
        )
        self.answer = answer


@dataclass(frozen=True, eq=False)
class _Offer:
    """An offered candidate; ``version``: of its frame, see ``_version``."""

    level: Level
    version: Version


class Objects:
    """Selects objects by clicks on the frames of a workspace; thread-safe."""

    def __init__(
        self,
        store: LabelStore,
        folder: Path,
        selector: str,
        publish: Callable[[Prepared], None],
        compile_loops: Callable[[], None],
        options: ObjectOptions | None = None,
    ) -> None:
        """``folder``: of prepared frames; ``compile_loops`` waits until loops are compiled.

        Raises BadInputError for an unknown selector.
        """
        self._options = options or ObjectOptions()
        self._store, self._name = store, selector
        self._offers: Cache[str, _Offer] = Cache(self._options.answers)
        self._states = States(
            Selectors.parse(selector), folder, publish, compile_loops, self._options
        )

    def close(self) -> None:
        """Stop the preparation."""
        self._states.close()

    def problems(self, *, repair: bool) -> tuple[list[str], list[str]]:
        """Return a sentence for each damaged file of a prepared frame; see ``States.problems``."""
        return self._states.problems(repair=repair)

    def parse(self, fields: Any) -> Clicks:
        """Read clicks from the JSON fields of a call or a message; raises BadInputError."""
        return Clicks.parse(fields, self._options.clicks)

    # ── answering ────────────────────────────────────────────────────────────────────────

    def answer(self, recording: Recording, frame: int, clicks: Clicks) -> Answer:
        """Return the candidates of clicks; without positive ones only whether the frame is ready.

        The frame and its neighbours are queued for preparation.  Raises NotFoundError.
        """
        stored = recording[frame]
        ready = self._states.ready(recording, frame)
        if len(clicks.positives.origins) == 0 or stored.count == 0:
            return Answer((), 0, ready)
        # The version is read first: newer values then only invalidate this answer.
        version = self._version(recording, frame)
        values = self._store.values(recording.manifest.id, frame)
        kept = self._kept(recording.manifest.id, clicks)
        free = _free(values, kept, clicks, stored)
        points = frame_points(stored)
        shift = np.asarray(recording.manifest.shift, np.float64)
        seen = both(
            Seen(self._store.view(recording.manifest.id), frame, clicks.hidden).shown,
            of_shown_sensors(stored, clicks.hidden_sensors),
        )
        positives = surface_hits(points, clicks.positives, shift, seen)
        if len(positives) == 0:
            return Answer((), 0, ready)
        negatives = surface_hits(points, clicks.negatives, shift, seen)
        previous = self._offers.known(clicks.previous)
        mask = None if previous is None else previous.level.numbers
        found = self._states.candidates(recording, frame, points, positives, negatives, mask)
        clip = clicks.positives.to_local(shift).clip
        regions = [(numbers[free[numbers]], score) for numbers, score in found.regions]
        if clip is not None:
            regions = [(clip.of(points, numbers), score) for numbers, score in regions]
        key = (*version, self._name, kept, found.ready, clicks.previous, *clicks.cache_key())
        answer = _ladder(regions, repr(key).encode(), ready=found.ready)
        for each in answer.candidates:
            self._offers.put(each.id, _Offer(each, version))
        return answer

    def take(
        self, recording: Recording, frame: int, clicks: Clicks, candidate: str, level: int | None
    ) -> Level:
        """Return the candidate of a stroke by its id or level.

        An id is valid until the frame changes, also for a stroke with another label; points of
        labels that the stroke must not change are left out.  Raises StaleCandidateError for any
        other id, BadInputError for a level that is not offered.
        """
        known = self._offers.known(candidate)
        if known is not None and known.version == self._version(recording, frame):
            return self._allowed(recording, frame, clicks, known.level)
        answer = self.answer(recording, frame, clicks)
        if candidate:
            for each in answer.candidates:
                if each.id == candidate:
                    return each
            raise StaleCandidateError(answer)
        offered = len(answer.candidates)
        if offered == 0:
            raise BadInputError("positives: expected a ray that meets the frame, got none")
        wanted = answer.first if level is None else level
        if not 0 <= wanted < offered:
            raise BadInputError(f"level: expected 0 to {offered - 1}, got {wanted}")
        return answer.candidates[wanted]

    # ── rules and names ──────────────────────────────────────────────────────────────────

    def _kept(self, sequence: str, clicks: Clicks) -> list[int]:
        """Return the locked and hidden labels, ascending; their points are never selected."""
        palette = self._store.palette(sequence)
        kept = {label.id for label in palette if label.locked or not label.visible}
        return sorted(kept | clicks.hidden)

    def _version(self, recording: Recording, frame: int) -> Version:
        return recording.placement, frame, self._store.changed(recording.manifest.id, frame)

    def _allowed(self, recording: Recording, frame: int, clicks: Clicks, level: Level) -> Level:
        """Return the candidate without points that a stroke with ``clicks`` must not change."""
        sequence = recording.manifest.id
        values = self._store.values(sequence, frame)
        free = _free(values, self._kept(sequence, clicks), clicks, recording[frame])
        return replace(level, numbers=level.numbers[free[level.numbers]])


def _free(
    values: FrameValues, kept: list[int], clicks: Clicks, stored: StoredFrame
) -> NDArray[np.bool_]:
    """Return the mask (N,) of selectable points.

    They are not deleted, and have neither kept nor other labels nor a hidden sensor.
    """
    free = ~values.deleted & ~np.isin(values.label, kept)
    if not clicks.take_labelled:
        free &= (values.label == 0) | (values.label == clicks.label)
    shown = of_shown_sensors(stored, clicks.hidden_sensors)
    if shown is not None:
        free &= shown(np.arange(stored.count))
    return np.asarray(free)


def _ladder(regions: list[tuple[Numbers, float]], key: bytes, *, ready: bool) -> Answer:
    """Return regions by size, except empty and equal ones; the first given one is shown first."""
    kept: list[tuple[Numbers, float]] = []
    for numbers, score in regions:
        if len(numbers) and not any(len(numbers) == len(other) for other, _ in kept):
            kept.append((numbers, score))
    if not kept:
        return Answer((), 0, ready)
    order = sorted(range(len(kept)), key=lambda i: len(kept[i][0]))
    levels = tuple(
        Level(
            hashlib.blake2b(key + bytes([place]), digest_size=16).hexdigest(),
            place,
            kept[i][1],
            kept[i][0],
        )
        for place, i in enumerate(order)
    )
    return Answer(levels, order.index(0), ready)
