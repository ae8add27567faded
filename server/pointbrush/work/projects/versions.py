"""The service for versions of a project's labels: creation, reading and comparison."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import NotFoundError
from pointbrush.labels import Label
from pointbrush.labels.versions import Moment, PastLabels
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.team.snapshots import (
    Difference,
    DifferenceKind,
    FrameDifference,
    LabelDifference,
    Snapshot,
)
from pointbrush.work.annotate.layers import READ_POINTS
from pointbrush.work.reviewing.comparing import pairs
from pointbrush.work.trash import ids_for

Kind = DifferenceKind


class Versions:
    """The versions of a workspace's projects; thread-safe.

    Every method raises NotFoundError for an unknown project, version or recording in it.
    """

    def __init__(self, store: WorkspaceStore) -> None:
        self._store = store

    def create(self, project: str, name: str, author: str) -> Snapshot:
        """Create a version of a project's current labels."""
        there = {
            version.id
            for each in self._store.team.projects.all()
            for version in self._store.versions.all(each.id)
        }
        wanted = next(each for each in ids_for(name) if each not in there)
        return self._named(self._store.versions.create(project, wanted, name, author))

    def all(self, project: str) -> list[Snapshot]:
        """Return the versions of a project, newest first."""
        self._store.team.projects.get(project)
        return [self._named(each) for each in self._store.versions.all(project)]

    def get(self, project: str, version: str) -> Snapshot:
        """Return a version."""
        return self._named(self._store.versions.get(project, version))

    def remove(self, project: str, version: str) -> None:
        """Delete a version; labels are kept."""
        self._store.versions.remove(project, version)

    def labels(self, sequence: str, version: str) -> PastLabels:
        """Return the labels of a recording in a version."""
        return self._store.at(self._store.versions.moment(version, sequence))

    def labels_at(self, sequence: str, revision: int) -> PastLabels:
        """Return the labels of a recording after the edit ``revision``, with today's palette."""
        return self._store.at(replace(self._store.versions.now(sequence), revision=revision))

    def difference(
        self, project: str, version: str, other: str | None = None, sequence: str | None = None
    ) -> list[Difference]:
        """Compare a version with a later one, or with the current labels (None).

        ``sequence``: only this recording; recordings that are not in both are left out.
        """
        first = self._store.versions.get(project, version).recordings
        second = None if other is None else self._store.versions.get(project, other).recordings
        if sequence is not None and sequence not in first:
            raise NotFoundError(f"sequence: expected one of {version!r}, got {sequence!r}")
        chosen = first.keys() if sequence is None else {sequence}
        if second is not None:
            chosen = chosen & second.keys()
        found = [self._compare(each, version, other) for each in sorted(chosen)]
        return [each for each in found if each.labels or each.frames]

    def _compare(self, sequence: str, version: str, other: str | None) -> Difference:
        moments = [self._store.versions.moment(version, sequence)]
        versions = self._store.versions
        later = versions.now(sequence) if other is None else versions.moment(other, sequence)
        moments.append(later)
        swapped = moments[0].revision > later.revision
        past = [self._store.at(moment) for moment in moments]
        since = min(moment.revision for moment in moments)
        frames = past[0 if swapped else 1].changed_frames(sequence, since)
        found = (_frame(sequence, frame, *past) for frame in frames)
        differing = tuple(each for each in found if each is not None)
        return Difference(sequence, tuple(_labels(*moments)), differing)

    def _named(self, version: Snapshot) -> Snapshot:
        return replace(version, author=self._store.accounts.name(version.author))


def _labels(first: Moment, second: Moment) -> list[LabelDifference]:
    found = []
    for number in sorted(first.palette.keys() | second.palette.keys()):
        before, after = first.palette.get(number), second.palette.get(number)
        if before is None and after is not None:
            found.append(LabelDifference(number, after.name, "came"))
        elif before is not None and after is None:
            found.append(LabelDifference(number, before.name, "went"))
        elif before and after and _appearance(before) != _appearance(after):
            found.append(LabelDifference(number, after.name, "changed"))
    return found


def _appearance(label: Label) -> tuple[str, str, str]:
    return label.name, label.category, label.color


def _frame(
    sequence: str, frame: int, first: PastLabels, second: PastLabels
) -> FrameDifference | None:
    added = removed = changed = 0
    objects: tuple[set[int], set[int]] = set(), set()
    for before, after in zip(
        _seen(first, sequence, frame), _seen(second, sequence, frame), strict=True
    ):
        for (mine, theirs), points in pairs(before, after).items():
            objects[0].add(mine)
            objects[1].add(theirs)
            if mine == theirs:
                continue
            added += points if not mine else 0
            removed += points if not theirs else 0
            changed += points if mine and theirs else 0
    if not added + removed + changed:
        return None
    gone, fresh = objects[0] - objects[1] - {0}, objects[1] - objects[0] - {0}
    return FrameDifference(
        frame, added, removed, changed, tuple(sorted(fresh)), tuple(sorted(gone))
    )


def _seen(past: PastLabels, sequence: str, frame: int) -> Iterator[NDArray[np.uint16]]:
    for values in past.runs(sequence, frame, READ_POINTS):
        yield np.where(values.deleted, np.uint16(0), values.label)
