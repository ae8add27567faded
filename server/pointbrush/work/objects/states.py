"""Prepared frames in memory and on disk, and surroundings of clicks until a frame is ready."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import BadInputError
from pointbrush.selection import Points
from pointbrush.selection.selectors import StateLostError, StoredSelector
from pointbrush.sequences import Sequence as Recording
from pointbrush.work.events import Prepared
from pointbrush.work.objects.choosing import Selectors
from pointbrush.work.objects.frames import near, object_frame
from pointbrush.work.objects.options import ObjectOptions
from pointbrush.work.objects.preparing import Preparer, StateFiles

Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Found:
    """Regions of clicks; ``ready``: they are based on the whole frame."""

    regions: list[tuple[Numbers, float]]
    ready: bool


@dataclass(frozen=True, eq=False)
class _Near:
    """Prepared surroundings of a click: ``members`` (n,) are their stored numbers."""

    state: Any
    members: Numbers
    middle: Floats
    reach: float


class States:
    """Runs a recording's selector on prepared frames; thread-safe."""

    def __init__(
        self,
        selectors: Selectors,
        folder: Path,
        publish: Callable[[Prepared], None],
        compile_loops: Callable[[], None],
        options: ObjectOptions,
    ) -> None:
        """``folder``: of prepared frames; ``compile_loops`` waits until loops are compiled."""
        self._selectors, self._publish, self._options = selectors, publish, options
        self._compile = compile_loops
        self._files = StateFiles(folder, options.disk_bytes)
        self._states: Cache[tuple[str, int], Any] = Cache(options.memory_bytes)
        self._near: Cache[tuple[str, int, bytes], _Near] = Cache(options.near_kept)
        self._preparer = Preparer(selectors, self._files, options.waiting, self._prepared)

    def close(self) -> None:
        """Stop the preparation."""
        self._preparer.close()

    def problems(self, *, repair: bool) -> tuple[list[str], list[str]]:
        """Return sentences about removed files, and about other files that a selector cannot read.

        ``repair``: remove unreadable files.
        """
        removed: list[str] = []
        left: list[str] = []
        if not self._files.folder.is_dir():
            return removed, left  # selectors are slow to import
        for chosen in self._selectors.every():
            selector = chosen.selector
            if not isinstance(selector, StoredSelector):
                continue
            for path in self._files.of(chosen.name, selector.version):
                try:
                    selector.load(path)
                except BadInputError as error:
                    if path.exists():  # not removed by another process
                        gone = repair and self._files.remove(path)
                        name = path.relative_to(self._files.folder.parent)
                        (removed if gone else left).append(f"{name.parent}: {error}")
        return removed, left

    def ready(self, recording: Recording, frame: int) -> bool:
        """Return whether a frame is prepared; if not, queue it and its neighbours."""
        if self._state(recording, frame) is not None:
            return True
        self._expect(recording, frame)
        return False

    def candidates(
        self,
        recording: Recording,
        frame: int,
        points: Points,
        positives: Floats,
        negatives: Floats,
        mask: Numbers | None,
    ) -> Found:
        """Return the regions of clicks at places (K, 3), (L, 3), local metres.

        Waits until the loops are compiled.  Raises StateLostError if the selector has lost the
        frame's state; it is prepared again.
        """
        self._compile()
        selector = self._selectors.of(recording.manifest.id).selector
        state = self._state(recording, frame)
        try:
            if state is None:
                near_by = self._near_by(recording, frame, points, positives, negatives, mask)
                return Found(near_by, ready=False)
            found = selector.candidates(state, positives, negatives, mask)
            return Found([(numbers, float(score)) for numbers, score in found], ready=True)
        except StateLostError:
            self._forget(recording, frame)
            raise

    def _state(self, recording: Recording, frame: int) -> Any | None:
        if recording[frame].count > self._options.whole_points:
            return None
        key = (recording.placement, frame)
        found = self._states.known(key)
        chosen = self._selectors.of(recording.manifest.id)
        if found is not None or not isinstance(chosen.selector, StoredSelector):
            return found
        path = self._files.path(recording.placement, chosen.name, chosen.selector.version, frame)
        try:
            size = path.stat().st_size
            state = chosen.selector.load(path)
        except OSError:
            return None
        except BadInputError:
            self._files.remove(path)  # the frame is prepared again
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
        self._preparer.request(recording, wanted)

    def _forget(self, recording: Recording, frame: int) -> None:
        """Prepare a frame again after its selector has lost the state."""
        self._states.drop((recording.placement, frame))
        self._near.drop(*self._near.held())
        chosen = self._selectors.of(recording.manifest.id)
        if isinstance(chosen.selector, StoredSelector):
            path = self._files.path(
                recording.placement, chosen.name, chosen.selector.version, frame
            )
            path.unlink(missing_ok=True)
        self._expect(recording, frame)

    def _prepared(self, recording: Recording, frame: int, state: object) -> None:
        if state is not None:
            size = max(recording[frame].count * 16, 1)
            self._states.get((recording.placement, frame), lambda: state, size=size)
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
        selector = self._selectors.of(recording.manifest.id).selector
        found = selector.candidates(around.state, positives, negatives, inside)
        return [(around.members[numbers], score) for numbers, score in found]

    def _surroundings(
        self, recording: Recording, frame: int, points: Points, positives: Floats
    ) -> _Near:
        middle = positives.mean(axis=0)
        frame_key = (recording.placement, frame)
        for key in self._near.held():
            known = self._near.known(key) if key[:2] == frame_key else None
            if known and np.abs(positives - known.middle).max() < 0.5 * known.reach:
                return known
        members = near(points, middle, self._options.near_reach, self._options.near_points)
        wanted = object_frame(recording[frame], recording.manifest, members)
        reach = float(np.abs(points.xyz[members] - middle).max(initial=0.0))
        selector = self._selectors.of(recording.manifest.id).selector
        made = _Near(selector.prepare(wanted), members, middle, reach)
        self._near.put((*frame_key, middle.tobytes()), made)
        return made
