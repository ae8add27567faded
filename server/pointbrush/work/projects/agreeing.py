"""Copies of recordings for several people: made, compared by points and objects, merged, scored."""

from __future__ import annotations

import os
import shutil
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.labels import Commit, Label, LabelStore, Write
from pointbrush.labels.copies import Copy, CopyKind
from pointbrush.labels.palette import Palette, free_name_and_color
from pointbrush.labels.types import PAINTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences.manifest import rename_sequence
from pointbrush.sequences.recording_files import FolderFiles, RecordingFiles
from pointbrush.work.imports.source_labels import came_with_files, edit_of
from pointbrush.work.library import Library
from pointbrush.work.projects import matching
from pointbrush.work.reviewing import comparing
from pointbrush.work.trash import ids_for

Labels = NDArray[np.uint16]
HANDED_IN = frozenset({"done", "review", "accepted"})
"""States of tasks whose labels are compared."""
MAJORITY = "majority"
FEWEST = 3
"""People of whom a majority can be taken."""


@dataclass(frozen=True, slots=True)
class Place:
    """A disagreement in a frame; ``first``, ``second``: names of the labels of either.

    ``place``: a point that differs, source metres; None in an octree.
    """

    kind: matching.Kind
    frame: int
    first: tuple[str, ...]
    second: tuple[str, ...]
    points: int
    place: tuple[float, float, float] | None


@dataclass(frozen=True, slots=True)
class Pair:
    """Agreement of two copies: by points, and the places where they differ, the largest first."""

    first: str
    second: str
    agreement: comparing.Agreement
    places: Sequence[Place]


@dataclass(frozen=True, slots=True)
class Score:
    """Frames of known truth that a person has labelled; ``miou`` by class, of points.

    ``found``, ``missed``, ``added``: objects of the truth that are there, or not; others.
    """

    account: str
    frames: int
    miou: float | None
    found: int
    missed: int
    added: int


class Agreeing:
    """Work of several people on the same points; thread-safe."""

    def __init__(self, store: LabelStore, library: Library) -> None:
        self._store, self._library = store, library

    def copy(self, sequence: str, project: str, frames: range, kind: CopyKind) -> str:
        """Make a copy of a recording, with its palette; returns its id.

        One for agreement begins with the labels of ``frames`` as they are, one with known truth
        without any.  Raises NotFoundError.
        """
        recording, library, store = self._library.recording(sequence), self._library, self._store
        library.require_writable()
        known = [*store.recordings.live(), *store.recordings.deleted()]
        taken = {one.id for one in known}
        ids = ids_for(recording.manifest.name)  # as an import of the same file would get
        guard = store.guards.reserve(ids, lambda id_: id_ not in taken and library.is_free(id_))
        try:
            with library.store.staging() as partial:
                _linked(library.store.files(sequence), partial)
                manifest = rename_sequence(partial, guard.sequence)
                store.recordings.register(guard.sequence, manifest.points, manifest.identity)
                store.team.copies.mark(guard.sequence, sequence, project, kind)
                library.store.publish(partial, guard.sequence)
        finally:
            store.guards.end(guard)
        store.team.access.forget()
        palette = [replace(each, locked=False) for each in store.palette(sequence)]
        chosen = frames if kind == "agreement" else range(0)
        store.apply(  # as labels that came with the files: its history tells nobody what it is
            guard.sequence,
            edit_id=edit_of(recording.manifest),
            author="import",
            kind="import",
            writes=lambda _: (palette, self._copied(recording, chosen)),
            summary=came_with_files(len(chosen)),
        )
        return guard.sequence

    def _copied(self, recording: Recording, frames: range) -> Iterator[tuple[int, Write]]:
        for frame in frames:
            values = self._store.values(recording.manifest.id, frame)
            held = np.flatnonzero((values.label > 0) | values.deleted)
            if len(held):
                yield (
                    frame,
                    Write(
                        held,
                        label=values.label[held],
                        provenance=values.provenance[held],
                        deleted=values.deleted[held],
                    ),
                )

    def compare(self, project: str, sequence: str) -> list[Pair]:
        """Compare each two copies of a recording in the frames that both have handed in."""
        recording = self._library.recording(sequence)
        copies = self._copies(project, sequence)
        pairs = []
        for one, other in combinations(copies, 2):
            frames = sorted(_handed_in(one) & _handed_in(other))
            pairs.append(self._pair(recording, one, other, frames))
        return pairs

    def _pair(self, recording: Recording, one: Copy, other: Copy, frames: Sequence[int]) -> Pair:
        palettes = [self._palette(each.id) for each in (one, other)]
        classes = [{n: _class(label) for n, label in each.items()} for each in palettes]
        counted, places = {}, []
        for frame in frames:
            labels = [self._labels(each.id, frame) for each in (one, other)]
            counted[frame] = comparing.pairs(*labels)
            for found in matching.disagreements(counted[frame], classes[0], classes[1]):
                mine, theirs = np.isin(labels[0], found.first), np.isin(labels[1], found.second)
                differs = mine ^ theirs if found.kind == "outline" else mine | theirs
                called = (_names(palettes[0], found.first), _names(palettes[1], found.second))
                place = _place(recording, frame, differs)
                places.append(Place(found.kind, frame, *called, found.points, place))
        places.sort(key=lambda each: (-each.points, each.frame))
        return Pair(one.id, other.id, comparing.agreement(counted, *classes), places)

    def merge(
        self, project: str, sequence: str, take: str, author: str, edit_id: str | None = None
    ) -> Commit:
        """Write one copy's labels, or those of the majority, into the recording, as one edit.

        ``take``: the id of a copy, or "majority" of three or more, in frames that all of them have
        handed in; points about which no majority agrees stay as they are.
        Raises NotFoundError, BadInputError for too few people.
        """
        copies = self._copies(project, sequence)
        if take != MAJORITY:
            copies = [each for each in copies if each.id == take]
            if not copies:
                raise NotFoundError(f"take: expected a copy of {sequence!r}, got {take!r}")
        elif len(copies) < FEWEST:
            raise BadInputError(f"take: expected {FEWEST} people or more, there are {len(copies)}")
        frames = sorted(set.intersection(*map(_handed_in, copies)))
        if not frames:
            raise BadInputError("take: expected frames that are handed in, there are none")
        numbers = self._numbers(copies, frames)

        def choose(palette: Palette) -> tuple[list[Label], Iterator[tuple[int, Write]]]:
            ids, fresh = self._chosen(copies, numbers, palette)
            return fresh, self._merged(sequence, copies, frames, numbers, ids)

        return self._store.apply(
            sequence,
            edit_id=edit_id,
            author=author,
            kind="merge",
            writes=choose,
            summary=lambda points, changed: f"merged {take}: {points} points in {changed} frames",
        )

    def _numbers(self, copies: Sequence[Copy], frames: Sequence[int]) -> dict[matching.Member, int]:
        if len(copies) == 1:
            return {(0, label): label for label in self._palette(copies[0].id)}
        total: dict[tuple[int, int], Counter[tuple[int, int]]] = defaultdict(Counter)
        for frame in frames:
            labels = [self._labels(each.id, frame) for each in copies]
            for ends, counted in matching.pairs_of_people(labels).items():
                total[ends].update(counted)
        return matching.groups(total)

    def _chosen(
        self, copies: Sequence[Copy], numbers: Mapping[matching.Member, int], palette: Palette
    ) -> tuple[NDArray[np.uint16], list[Label]]:
        """Return the label of each object in the recording, by its number, and the new ones.

        An object is called as most call it; one that is there already keeps its label.
        """
        members: dict[int, list[Label]] = defaultdict(list)
        for (who, number), group in sorted(numbers.items()):
            members[group].append(self._palette(copies[who].id)[number])
        there = {label.id: label for label in palette.labels}
        free, fresh, taken = palette.free_ids(), list[Label](), set[int]()
        ids = np.zeros(max(numbers.values(), default=0) + 1, np.uint16)
        for group, labels in sorted(members.items()):
            names = Counter((each.name, each.category) for each in labels)
            called = max(names, key=lambda each: names[each])
            likest = next(each for each in labels if (each.name, each.category) == called)
            own = there.get(likest.id)
            if own is None or (own.name, own.category) != called or own.id in taken:
                looks = free_name_and_color(
                    {"name": likest.name, "color": likest.color}, [*there.values(), *fresh]
                )
                number = free.take((looks["name"], likest.category))
                own = replace(likest, id=number, position=None, **looks)
                fresh.append(own)
            taken.add(own.id)
            ids[group] = own.id
        return ids, fresh

    def _merged(
        self,
        sequence: str,
        copies: Sequence[Copy],
        frames: Sequence[int],
        numbers: Mapping[matching.Member, int],
        ids: NDArray[np.uint16],
    ) -> Iterator[tuple[int, Write]]:
        for frame in frames:
            labels = [self._labels(each.id, frame) for each in copies]
            voted = matching.majority(labels, numbers)
            wanted = np.where(voted == matching.UNDECIDED, 0, ids[np.maximum(voted, 0)])
            now = self._store.values(sequence, frame).label
            differs = np.flatnonzero((voted != matching.UNDECIDED) & (wanted != now))
            if len(differs):
                provenance = np.where(wanted[differs] > 0, PAINTED, 0).astype(np.uint8)
                yield (
                    frame,
                    Write(differs, label=wanted[differs].astype(np.uint16), provenance=provenance),
                )

    def scores(self, project: str) -> list[Score]:
        """Compare what each person has handed in of known truth with it; the best come first."""
        pairs: dict[str, list[tuple[Copy, int]]] = defaultdict(list)
        for copy in self._store.team.copies.of(project, "truth"):
            for task in copy.tasks:
                if task.state in HANDED_IN and task.assignee:
                    frames = range(task.first, task.last + 1)
                    pairs[task.assignee] += [(copy, frame) for frame in frames]
        found = [self._score(account, of_them) for account, of_them in pairs.items()]
        return sorted(found, key=lambda each: (-(each.miou or 0.0), each.account))

    def _score(self, account: str, frames: Sequence[tuple[Copy, int]]) -> Score:
        counted: dict[int, Counter[tuple[str, str]]] = {}
        objects: Counter[str] = Counter()
        for at, (copy, frame) in enumerate(frames):
            truth, own = self._palette(copy.original), self._palette(copy.id)
            shared = comparing.pairs(
                self._labels(copy.original, frame), self._labels(copy.id, frame)
            )
            classes: Counter[tuple[str, str]] = Counter()
            for (right, mine), points in shared.items():
                classes[_class(truth.get(right)), _class(own.get(mine))] += points
            counted[at] = classes
            good = matching.matches(shared, matching.MatchOptions(least=0.5))
            same = [m for m in good if _class(truth.get(m.first)) == _class(own.get(m.second))]
            objects["found"] += len(same)
            objects["missed"] += len({a for a, _ in shared} - {0}) - len(same)
            objects["added"] += len({b for _, b in shared} - {0}) - len(same)
        names = {name for each in counted.values() for ends in each for name in ends} - {""}
        numbers = {name: number for number, name in enumerate(sorted(names), 1)}
        as_numbers = {
            at: Counter({(numbers.get(a, 0), numbers.get(b, 0)): n for (a, b), n in each.items()})
            for at, each in counted.items()
        }
        back = {number: name for name, number in numbers.items()}
        agreed = comparing.agreement(as_numbers, back, back)
        return Score(
            self._store.accounts.name(account), len(frames), agreed.miou,
            objects["found"], objects["missed"], objects["added"],
        )  # fmt: skip

    def _copies(self, project: str, sequence: str) -> list[Copy]:
        self._library.recording(sequence)
        return self._store.team.copies.of(project, "agreement", sequence)

    def _palette(self, sequence: str) -> dict[int, Label]:
        return {label.id: label for label in self._store.palette(sequence)}

    def _labels(self, sequence: str, frame: int) -> Labels:
        values = self._store.values(sequence, frame)
        return np.where(values.deleted, np.uint16(0), values.label)


def _linked(files: RecordingFiles, target: Path) -> None:
    """Copy a recording; where it is a folder, by links to its files, which never change."""

    def link(source: str, place: str) -> None:
        try:
            os.link(source, place)
        except OSError:  # of a file system without links
            shutil.copy2(source, place)

    if isinstance(files, FolderFiles):
        shutil.copytree(files.path, target, copy_function=link)
    else:
        files.copy_to(target)


def _names(palette: Mapping[int, Label], labels: Sequence[int]) -> tuple[str, ...]:
    return tuple(palette[number].name for number in labels if number in palette)


def _handed_in(copy: Copy) -> set[int]:
    return {
        frame
        for task in copy.tasks
        if task.state in HANDED_IN
        for frame in range(task.first, task.last + 1)
    }


def _class(label: Label | None) -> str:
    return "" if label is None else label.category.strip() or label.name.strip()


def _place(
    recording: Recording, frame: int, differs: NDArray[np.bool_]
) -> tuple[float, float, float] | None:
    """Return the point among those that differ which is nearest to the middle of them."""
    if recording.manifest.large or not differs.any():
        return None
    stored = recording[frame]
    xyz = stored.xyz[differs].astype(np.float64) + recording.manifest.shift
    x, y, z = xyz[((xyz - np.median(xyz, axis=0)) ** 2).sum(axis=1).argmin()].tolist()
    return x, y, z
