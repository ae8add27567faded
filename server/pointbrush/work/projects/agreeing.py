"""Comparing, merging and scoring copies of recordings for several people."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.labels import Commit, Label, Write
from pointbrush.labels.classes.palette import Palette, free_name_and_color
from pointbrush.labels.types import PAINTED
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork import matching
from pointbrush.teamwork.copies import Copy
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.team.tasks import CopyAgreement, Disagreement, Region, Score
from pointbrush.work.library import Library
from pointbrush.work.reviewing import comparing

Labels = NDArray[np.uint16]
HANDED_IN = frozenset({"done", "review", "accepted"})
"""States of tasks with labels to compare."""
MAJORITY = "majority"
FEWEST = 3
"""Minimum number of people for a majority."""


class Agreeing:
    """Comparison of several people's labels of the same points; thread-safe."""

    def __init__(self, store: WorkspaceStore, library: Library) -> None:
        self._store, self._library = store, library

    def compare(self, project: str, sequence: str) -> list[CopyAgreement]:
        """Compare each pair of copies of a recording in the frames that both have handed in."""
        recording = self._library.recording(sequence)
        copies = self._copies(project, sequence)
        pairs = []
        for one, other in combinations(copies, 2):
            frames = sorted(_handed_in(one) & _handed_in(other))
            pairs.append(self._pair(recording, one, other, frames))
        return pairs

    def _pair(
        self, recording: Recording, one: Copy, other: Copy, frames: Sequence[int]
    ) -> CopyAgreement:
        known = [self._palette(each) for each in (one.id, other.id, one.original)]
        classes = [{n: _class(label) for n, label in each.items()} for each in known]
        counted, places = {}, []
        for frame in frames:
            labels = [self._labels(each, frame) for each in (one.id, other.id, one.original)]
            counted[frame] = comparing.pairs(*labels[:2])
            for found in matching.disagreements(counted[frame], classes[0], classes[1]):
                mine, theirs = np.isin(labels[0], found.first), np.isin(labels[1], found.second)
                either = mine | theirs
                place = _place(
                    recording, frame, mine ^ theirs if found.kind == "outline" else either
                )
                parts = [each[either] for each in labels]
                has = next((k for k in (0, 1) if _alike(parts, classes, k)), None)
                called = (_names(known[0], found.first), _names(known[1], found.second))
                ends = (found.first, found.second)
                places.append(
                    Disagreement(found.kind, frame, *called, ends, found.points, has, place)
                )
        places.sort(key=lambda each: (-each.points, each.frame))
        agreement = comparing.agreement(counted, *classes[:2])
        return CopyAgreement(one.id, other.id, agreement, tuple(places))

    def merge(
        self,
        project: str,
        sequence: str,
        take: str,
        author: str,
        *,
        edit_id: str | None = None,
        region: Region | None = None,
    ) -> Commit:
        """Write the labels of one copy, or of the majority, to the recording as one edit.

        ``take``: the id of a copy, or "majority" of three or more, in frames that all of them have
        handed in.  Points without a majority and points outside ``region`` are not changed.  Raises
        NotFoundError, BadInputError for too few people.
        """
        named = {each.id: each for each in self._copies(project, sequence)}
        region = region or Region({})
        for name in ({take} - {MAJORITY}) | region.labels.keys():
            if name not in named:
                raise NotFoundError(f"take: expected copies of {sequence!r}, got {name!r}")
        copies = [*named.values()] if take == MAJORITY else [named[take]]
        if take == MAJORITY and len(copies) < FEWEST:
            raise BadInputError(f"take: expected {FEWEST} people or more, there are {len(copies)}")
        involved = [*copies, *(named[name] for name in region.labels)]
        frames = sorted(set.intersection(*map(_handed_in, involved)))
        if region.frame is not None:
            frames = [frame for frame in frames if frame == region.frame]
        if not frames:
            raise BadInputError("take: expected frames that are handed in, there are none")
        numbers = self._numbers(copies, frames, region)

        def choose(palette: Palette) -> tuple[list[Label], Iterator[tuple[int, Write]]]:
            ids, fresh = self._chosen(copies, numbers, palette)
            return fresh, self._merged(sequence, copies, frames, region, numbers, ids)

        return self._store.apply(
            sequence,
            edit_id=edit_id,
            author=author,
            kind="merge",
            writes=choose,
            summary=lambda points, changed: f"merged {take}: {points} points in {changed} frames",
        )

    def _numbers(
        self, copies: Sequence[Copy], frames: Sequence[int], region: Region
    ) -> dict[matching.Member, int]:
        if len(copies) == 1:
            used = {
                number
                for frame in frames
                for number in np.unique(self._labels(copies[0].id, frame)[self._in(region, frame)])
            }
            return {(0, int(label)): int(label) for label in used - {0}}
        total: dict[tuple[int, int], Counter[tuple[int, int]]] = defaultdict(Counter)
        for frame in frames:
            labels = [self._labels(each.id, frame) for each in copies]
            for ends, counted in matching.pairs_of_people(labels).items():
                total[ends].update(counted)
        return matching.groups(total)

    def _in(self, region: Region, frame: int) -> NDArray[np.bool_] | slice:
        """Return an index of the points of a region."""
        if not region.labels:
            return slice(None)
        masks = [np.isin(self._labels(name, frame), each) for name, each in region.labels.items()]
        found: NDArray[np.bool_] = np.logical_or.reduce(masks)
        return found

    def _chosen(
        self, copies: Sequence[Copy], numbers: Mapping[matching.Member, int], palette: Palette
    ) -> tuple[NDArray[np.uint16], list[Label]]:
        """Return the recording's label for each object, by its number, and new labels.

        An object gets its most frequent name; an existing label with this name is reused.
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
            alike = [each for each in there.values() if (each.name, each.category) == called]
            alike.sort(key=lambda each: each.id != likest.id)
            own = next((each for each in alike if each.id not in taken), None)
            if own is None:
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
        region: Region,
        numbers: Mapping[matching.Member, int],
        ids: NDArray[np.uint16],
    ) -> Iterator[tuple[int, Write]]:
        for frame in frames:
            labels = [self._labels(each.id, frame) for each in copies]
            voted = matching.majority(labels, numbers)
            wanted = np.where(voted == matching.UNDECIDED, 0, ids[np.maximum(voted, 0)])
            now = self._store.values(sequence, frame).label
            meant = np.zeros(len(now), np.bool_)
            meant[self._in(region, frame)] = True
            differs = np.flatnonzero(meant & (voted != matching.UNDECIDED) & (wanted != now))
            if len(differs):
                provenance = np.where(wanted[differs] > 0, PAINTED, 0).astype(np.uint8)
                yield (
                    frame,
                    Write(differs, label=wanted[differs].astype(np.uint16), provenance=provenance),
                )

    def scores(self, project: str) -> list[Score]:
        """Return the score of each person's handed-in labels against ground truth, best first."""
        pairs: dict[str, list[tuple[Copy, int]]] = defaultdict(list)
        for copy in self._store.team.copies.of(project, "truth"):
            for task in copy.tasks:
                if task.state in HANDED_IN and task.assignee:
                    frames = range(task.first, task.last + 1)
                    pairs[task.assignee] += [(copy, frame) for frame in frames]
        found = [self._score(account, of_them) for account, of_them in pairs.items()]
        return sorted(found, key=lambda each: (-(each.miou or 0.0), each.person))

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
    """Return the differing point nearest to the median of all differing points."""
    if recording.manifest.large or not differs.any():
        return None
    stored = recording[frame]
    xyz = stored.xyz[differs].astype(np.float64) + recording.manifest.shift
    x, y, z = xyz[((xyz - np.median(xyz, axis=0)) ** 2).sum(axis=1).argmin()].tolist()
    return x, y, z


def _alike(
    parts: Sequence[NDArray[np.uint16]], classes: Sequence[Mapping[int, str]], who: int
) -> bool:
    """Return whether the recording, the last of ``parts``, has the objects of person ``who``."""
    pairs = comparing.pairs(parts[who], parts[-1]).keys()
    one_to_one = len({a for a, _ in pairs}) == len({b for _, b in pairs}) == len(pairs)
    return one_to_one and all(
        bool(a) == bool(b) and classes[who].get(a) == classes[-1].get(b) for a, b in pairs
    )
