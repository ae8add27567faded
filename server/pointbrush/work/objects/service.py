"""Clicks on a frame → nested candidates, remembered until one of them is taken."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, ConflictError
from pointbrush.labels import FrameValues, LabelStore
from pointbrush.selection import Points
from pointbrush.selection.selectors import StateLostError, StoredSelector, make_selector
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.cache import Cache
from pointbrush.work.events import Prepared
from pointbrush.work.objects.cache import StateFiles
from pointbrush.work.objects.clicks import Clicks, surface_hits
from pointbrush.work.objects.frames import near, object_frame
from pointbrush.work.objects.options import ObjectOptions
from pointbrush.work.objects.preparing import Preparer
from pointbrush.work.seen import Seen
from pointbrush.work.strokes import frame_points

Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Level:
    """A candidate: ``numbers`` are the points that it would take, stored order, ascending.

    ``id`` is opaque, and stands for state, clicks and revision; ``level`` counts from the smallest.
    """

    id: str
    level: int
    score: float
    numbers: Numbers


@dataclass(frozen=True, eq=False)
class Answer:
    """Candidates of some clicks, from part to group; ``first`` is the one to show first.

    ``ready``: they come from all of the frame, not from what is near the clicks.
    """

    candidates: tuple[Level, ...]
    first: int
    ready: bool


class StaleCandidateError(ConflictError):
    """The frame changed since a candidate was offered; ``answer`` holds what is offered now."""

    title = "Candidate is stale"

    def __init__(self, answer: Answer) -> None:
        super().__init__("candidate: expected one of the newest answer; the frame has changed")
        self.answer = answer


@dataclass(frozen=True, eq=False)
class _Near:
    """Surroundings of a click, prepared: ``members`` (n,) are their stored numbers."""

    state: Any
    members: Numbers
    middle: Floats
    reach: float


class Objects:
    """Answers clicks on the frames of a workspace; thread-safe."""

    def __init__(
        self,
        store: LabelStore,
        folder: Path,
        selector: str,
        publish: Callable[[Prepared], None],
        options: ObjectOptions | None = None,
    ) -> None:
        """Prepared frames are kept in ``folder``.  Raises BadInputError for an unknown selector."""
        self._options = options or ObjectOptions()
        self._options.check()
        self._store, self._publish, self._name = store, publish, selector
        self._selector = make_selector(selector)
        self._files = StateFiles(folder, self._options.disk_bytes)
        self._states: Cache[tuple[str, int], Any] = Cache(self._options.memory_bytes)
        self._near: OrderedDict[tuple[str, int, bytes], _Near] = OrderedDict()
        self._answers: OrderedDict[str, Level] = OrderedDict()
        self._lock = threading.Lock()
        self._preparer = Preparer(
            self._selector, selector, self._files, self._options.waiting, self._prepared
        )

    def close(self) -> None:
        """Stop preparing."""
        self._preparer.close()

    def parse(self, fields: Any) -> Clicks:
        """Read clicks from the contract's JSON fields; raises BadInputError."""
        return Clicks.parse(fields, self._options.clicks)

    # ── answering ────────────────────────────────────────────────────────────────────────

    def answer(self, recording: Recording, frame: int, clicks: Clicks) -> Answer:
        """Return what clicks can mean; without a positive one, only whether the frame is ready.

        The frame is prepared after this, and those around it.  Raises NotFoundError.
        """
        stored = recording[frame]
        state = self._state(recording, frame)
        if state is None:
            self._expect(recording, frame)
        if len(clicks.positives.origins) == 0 or stored.count == 0:
            return Answer((), 0, state is not None)
        # Read first: values newer than it make the next answer another one, never this one wrong.
        revision = self._store.changed(recording.manifest.id, frame)
        values = self._store.values(recording.manifest.id, frame)
        kept = self._kept(recording.manifest.id, clicks)
        free = _free(values, kept, clicks)
        points = frame_points(stored)
        shift = np.asarray(recording.manifest.shift, np.float64)
        seen = Seen(self._store, recording.manifest.id, frame, clicks.hidden).shown
        positives = surface_hits(points, clicks.positives, shift, seen)
        if len(positives) == 0:
            return Answer((), 0, state is not None)
        negatives = surface_hits(points, clicks.negatives, shift, seen)
        mask = self._mask(clicks.previous)
        try:
            if state is None:
                found = self._near_by(recording, frame, points, positives, negatives, mask)
            else:
                found = list(self._selector.candidates(state, positives, negatives, mask))
        except StateLostError:
            self._forget(recording, frame)
            raise
        regions = [(numbers[free[numbers]], float(score)) for numbers, score in found]
        told = self._told(recording, frame, clicks, revision, kept, state is not None)
        answer = _ladder(regions, told, ready=state is not None)
        self._remember(answer)
        return answer

    def take(
        self, recording: Recording, frame: int, clicks: Clicks, candidate: str, level: int | None
    ) -> Level:
        """Return the candidate that a stroke names by its id, or by its level.

        Raises StaleCandidateError for an id that is not of the newest answer, BadInputError for a
        level that is not offered.
        """
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

    # ── states ───────────────────────────────────────────────────────────────────────────

    def _state(self, recording: Recording, frame: int) -> Any | None:
        if recording[frame].count > self._options.whole_points:
            return None
        key = (recording.identity, frame)
        found = self._states.known(key)
        if found is not None or not isinstance(self._selector, StoredSelector):
            return found
        path = self._files.path(recording.identity, self._name, self._selector.version, frame)
        try:
            size = path.stat().st_size
            state = self._selector.load(path)
        except (OSError, BadInputError):
            return None
        self._files.used(path)
        return self._states.get(key, lambda: state, size=max(size, 1))

    def _expect(self, recording: Recording, frame: int) -> None:
        around = [frame]
        for step in range(1, self._options.ahead + 1):
            around += [frame + step, frame - step]
        wanted = [
            number
            for number in around
            if 0 <= number < len(recording)
            and 0 < recording[number].count <= self._options.whole_points
        ]
        self._preparer.wish(recording, wanted)

    def _forget(self, recording: Recording, frame: int) -> None:
        """Have a frame prepared anew: its selector does not know its state any more."""
        self._states.drop((recording.identity, frame))
        with self._lock:
            self._near.clear()
        if isinstance(self._selector, StoredSelector):
            version = self._selector.version
            self._files.path(recording.identity, self._name, version, frame).unlink(missing_ok=True)
        self._expect(recording, frame)

    def _prepared(self, recording: Recording, frame: int, state: object) -> None:
        if state is not None:
            size = max(recording[frame].count * 16, 1)
            self._states.get((recording.identity, frame), lambda: state, size=size)
        self._publish(Prepared(recording.manifest.id, frame))

    def _near_by(
        self,
        recording: Recording,
        frame: int,
        points: Points,
        positives: Floats,
        negatives: Floats,
        mask: Numbers | None,
    ) -> list[tuple[Numbers, float]]:
        around = self._surroundings(recording, frame, points, positives)
        inside = None
        if mask is not None:
            at = np.searchsorted(around.members, mask)
            at = at[at < len(around.members)]
            inside = at[np.isin(around.members[at], mask)]
        found = self._selector.candidates(around.state, positives, negatives, inside)
        return [(around.members[numbers], score) for numbers, score in found]

    def _surroundings(
        self, recording: Recording, frame: int, points: Points, positives: Floats
    ) -> _Near:
        middle = positives.mean(axis=0)
        here = (recording.identity, frame)
        with self._lock:
            for key, known in self._near.items():
                inside = np.abs(positives - known.middle).max() < 0.5 * known.reach
                if key[:2] == here and inside:
                    self._near.move_to_end(key)
                    return known
        members = near(points, middle, self._options.near_reach, self._options.near_points)
        wanted = object_frame(recording[frame], recording.manifest, members)
        reach = float(np.abs(points.xyz[members] - middle).max(initial=0.0))
        made = _Near(self._selector.prepare(wanted), members, middle, reach)
        with self._lock:
            self._near[*here, middle.tobytes()] = made
            while len(self._near) > self._options.near_kept:
                self._near.popitem(last=False)
        return made

    # ── rules and names ──────────────────────────────────────────────────────────────────

    def _kept(self, sequence: str, clicks: Clicks) -> list[int]:
        """Return the labels, ascending, whose points no object takes: locked and hidden ones."""
        palette = self._store.palette(sequence)
        kept = {label.id for label in palette if label.locked or not label.visible}
        return sorted(kept | clicks.hidden)

    def _mask(self, previous: str) -> Numbers | None:
        with self._lock:
            known = self._answers.get(previous)
        return None if known is None else known.numbers

    def _told(
        self,
        recording: Recording,
        frame: int,
        clicks: Clicks,
        revision: int,
        kept: list[int],
        ready: bool,
    ) -> bytes:
        words = (
            recording.identity, frame, self._name, revision, kept, ready, clicks.previous,
            *clicks.words(),
        )  # fmt: skip
        return repr(words).encode()

    def _remember(self, answer: Answer) -> None:
        with self._lock:
            for level in answer.candidates:
                self._answers[level.id] = level
                self._answers.move_to_end(level.id)
            while len(self._answers) > self._options.answers:
                self._answers.popitem(last=False)


def _free(values: FrameValues, kept: list[int], clicks: Clicks) -> NDArray[np.bool_]:
    """Points (N,) that an object may take: not deleted, of no kept label, of no other one."""
    free = ~values.deleted & ~np.isin(values.label, kept)
    if not clicks.take_labelled:
        free &= (values.label == 0) | (values.label == clicks.label)
    return np.asarray(free)


def _ladder(regions: list[tuple[Numbers, float]], told: bytes, *, ready: bool) -> Answer:
    """Regions by size, without empty and equal ones; the first of them is the one to show."""
    kept: list[tuple[Numbers, float]] = []
    for numbers, score in regions:
        if len(numbers) and not any(len(numbers) == len(other) for other, _ in kept):
            kept.append((numbers, score))
    if not kept:
        return Answer((), 0, ready)
    order = sorted(range(len(kept)), key=lambda i: len(kept[i][0]))
    levels = tuple(
        Level(
            hashlib.blake2b(told + bytes([place]), digest_size=16).hexdigest(),
            place,
            kept[i][1],
            kept[i][0],
        )
        for place, i in enumerate(order)
    )
    return Answer(levels, order.index(0), ready)
