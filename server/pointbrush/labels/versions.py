"""Named versions of a project's labels, and reading the labels of a version.

The journal has the values before each edit, so the state at a revision is computed backwards from
the current state.  The palette is stored with the version.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Connection, and_, delete, func, insert, select

from pointbrush.database.class_names import read_names
from pointbrush.database.database import Database
from pointbrush.database.lost_answers import write_once
from pointbrush.database.project_rows import LONGEST_NAME, lock_project
from pointbrush.database.project_tables import version_recordings, versions
from pointbrush.database.schema import (
    LIVE,
    PROJECT_OF,
    WHOLE,
    edit_blocks,
    edit_tracks,
    edits,
    labels,
    sequences,
)
from pointbrush.errors import BadInputError, ConflictError, NotFoundError
from pointbrush.labels.boxes.editing import BoxList
from pointbrush.labels.boxes.journal import as_at, read_boxes
from pointbrush.labels.classes.palette import in_order
from pointbrush.labels.open_recordings import OpenRecordings
from pointbrush.labels.packing import (
    BLOCK,
    DELETION,
    LABELS,
    confidence_of,
    decode_change,
    deleted_of,
    label_of,
    provenance_of,
)
from pointbrush.labels.state import SequenceState, exists_table, visible
from pointbrush.labels.types import FrameValues, Label
from pointbrush.names import require_visible
from pointbrush.values.kinds import time_of
from pointbrush.values.team.snapshots import Snapshot

MOST_VERSIONS = 1_000
"""Limit for a project: each version has a palette per recording, and all are listed together."""
_FIELDS = tuple(name for name in Label.__dataclass_fields__ if name != "points")


@dataclass(frozen=True, slots=True)
class Moment:
    """A past state of a recording: row ``number``, ``revision`` and palette."""

    number: int
    revision: int
    palette: Mapping[int, Label]


class Versions:
    """The versions of all projects of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def create(self, project: str, version: str, name: str, author: str) -> Snapshot:
        """Create a version of the current labels of a project's recordings.

        Raises NotFoundError, ConflictError for an id that a version has, BadInputError for too many
        versions.
        """
        if not name.strip() or len(name) > LONGEST_NAME:
            raise BadInputError(f"name: expected 1 to {LONGEST_NAME} characters, got {len(name)}")
        require_visible("name", name)

        def make(connection: Connection) -> Snapshot:
            lock_project(connection, project)
            if _find(connection, version) is not None:
                raise ConflictError(f"id: expected one of no snapshot yet, got {version!r}")
            count = select(func.count()).where(versions.c.project == project)
            if connection.execute(count).scalar_one() >= MOST_VERSIONS:
                raise BadInputError(f"snapshots: expected at most {MOST_VERSIONS:,} in a project")
            now = self._database.now(connection)
            row = {"id": version, "project": project, "name": name, "created": now}
            connection.execute(insert(versions), row | {"author": author})
            rows = [
                {
                    "version": version,
                    "sequence": number,
                    "revision": revision,
                    "palette": json.dumps(palette),
                }
                for number, revision, palette in _moments(
                    connection, and_(project == PROJECT_OF, WHOLE)
                )
            ]
            if rows:
                connection.execute(insert(version_recordings), rows)
            return _get(connection, project, version)

        return write_once(self._database, make, lambda c: _find(c, version))

    def all(self, project: str) -> list[Snapshot]:
        """Return the versions of a project, newest first."""
        chosen = select(versions).where(versions.c.project == project)
        with self._database.read() as connection:
            rows = connection.execute(chosen.order_by(versions.c.created.desc())).all()
            return [_version(connection, row) for row in rows]

    def get(self, project: str, version: str) -> Snapshot:
        """Return a version; raises NotFoundError."""
        with self._database.read() as connection:
            return _get(connection, project, version)

    def remove(self, project: str, version: str) -> None:
        """Delete a version; labels are kept.  Raises NotFoundError."""
        with self._database.write() as connection:
            _get(connection, project, version)
            parts = version_recordings.c.version == version
            connection.execute(delete(version_recordings).where(parts))
            connection.execute(delete(versions).where(versions.c.id == version))

    def moment(self, version: str, sequence: str) -> Moment:
        """Return the state of a recording in a version; raises NotFoundError."""
        chosen = (
            select(version_recordings)
            .join(sequences, sequences.c.number == version_recordings.c.sequence)
            .where(version_recordings.c.version == version, sequences.c.id == sequence, LIVE)
        )
        with self._database.read() as connection:
            row = connection.execute(chosen).first()
            if row is None:
                expected = f"expected one with {sequence!r} in it"
                raise NotFoundError(f"snapshot: {expected}, got {version!r}")
            return _moment(connection, row.sequence, row.revision, json.loads(row.palette))

    def now(self, sequence: str) -> Moment:
        """Return the current state of a recording; raises NotFoundError."""
        with self._database.read() as connection:
            for row in _moments(connection, sequences.c.id == sequence):
                return _moment(connection, *row)
        raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")


class PastLabels:
    """Past labels of one recording, with the reading methods of a LabelStore."""

    def __init__(self, open_recordings: OpenRecordings, moment: Moment) -> None:
        self._open_recordings, self._moment = open_recordings, moment
        self.boxes = PastBoxes(open_recordings, moment)

    def palette(self, sequence: str) -> list[Label]:  # noqa: ARG002 - there is one recording
        """Return the labels in their order."""
        return list(self._moment.palette.values())

    def runs(self, sequence: str, frame: int, size: int) -> Iterator[FrameValues]:
        """Yield the annotation of a whole frame in runs of ``size`` points."""
        with self._open_recordings.reading(sequence) as (_, state):
            count = _same(state, self._moment).frame_points(frame)
        for first in range(0, max(count, 1), size):
            yield self.values(sequence, frame, first, size)

    def values(self, sequence: str, frame: int, first: int, count: int) -> FrameValues:
        """Return the annotation of points [first, first + count) of a frame, if they exist."""
        with self._open_recordings.reading(sequence) as (connection, state):
            stop = min(_same(state, self._moment).frame_points(frame), first + count)
            words = {
                layer: _words(connection, state, (frame, layer), first, stop, self._moment.revision)
                for layer in (LABELS, DELETION)
            }
        shown = visible(words[LABELS], exists_table(self._moment.palette))
        revision = self._moment.revision
        return FrameValues(
            label_of(shown),
            provenance_of(shown),
            deleted_of(words[DELETION]),
            confidence_of(shown),
            revision,
            revision,
        )

    def tracks(self, sequence: str) -> list[dict[str, Any]]:
        """Return the tracks of the labels at that time, by frame and label."""
        number, until = self._moment.number, self._moment.revision
        table = edit_tracks.c
        chosen = select(table.frame, table.label, table.revision, table.data).where(
            table.sequence == number, table.revision <= until
        )
        with self._open_recordings.reading(sequence) as (connection, state):
            _same(state, self._moment)
            undone = _undone(connection, number, until)
            rows = connection.execute(chosen.order_by(table.revision)).all()
        tracks = {
            (row.frame, row.label): row.data
            for row in rows
            if row.revision not in undone and row.label in self._moment.palette
        }
        return [json.loads(tracks[key]) for key in sorted(tracks)]

    def changed_frames(self, sequence: str, since: int) -> list[int]:
        """Return the frames that edits after revision ``since`` have changed."""
        chosen = select(edits.c.frames).where(
            edits.c.sequence == self._moment.number,
            edits.c.revision > since,
            edits.c.revision <= self._moment.revision,
        )
        with self._open_recordings.reading(sequence) as (connection, _):
            rows = connection.execute(chosen.distinct()).scalars().all()
        return sorted({frame for row in rows for frame in json.loads(row)})


class PastBoxes:
    """Past boxes of one recording, with the reading methods of a LabelStore."""

    def __init__(self, open_recordings: OpenRecordings, moment: Moment) -> None:
        self._open_recordings, self._moment = open_recordings, moment

    def listing(self, sequence: str) -> BoxList:
        """Return the boxes of the labels at that time."""
        number, until = self._moment.number, self._moment.revision
        with self._open_recordings.reading(sequence) as (connection, state):
            _same(state, self._moment)
            boxes = as_at(connection, number, until, _undone(connection, number, until))
        return BoxList(tuple(read_boxes(boxes, self._moment.palette.keys())), until)


def _same(state: SequenceState, moment: Moment) -> SequenceState:
    if state.number != moment.number:
        raise NotFoundError(f"snapshot: {state.id!r} was imported again after it")
    return state


def _words(
    connection: Connection,
    state: SequenceState,
    layer: tuple[int, int],
    first: int,
    stop: int,
    revision: int,
) -> np.ndarray[tuple[int], np.dtype[np.uint64]]:
    """Return the words of points first..stop - 1 of a layer of a frame at ``revision``."""
    if stop <= first:
        return np.zeros(0, np.uint64)
    begin, last = first // BLOCK, (stop - 1) // BLOCK
    blocks = state.block_run(connection, *layer, begin, last)
    words = np.zeros((last - begin + 1) * BLOCK, np.uint64)
    for number, block in enumerate(blocks):
        if block.states is not None:
            words[number * BLOCK : number * BLOCK + len(block.states)] = block.states
    table = edit_blocks.c
    later = select(table.block, table.data).where(
        table.sequence == state.number,
        table.frame == layer[0],
        table.layer == layer[1],
        table.block.between(begin, last),
        table.revision > revision,
    )
    for block, data in connection.execute(later.order_by(table.revision.desc())):
        change = decode_change(data)
        words[change.indices + (block - begin) * BLOCK] = change.before
    return words[first - begin * BLOCK : stop - begin * BLOCK]


def _undone(connection: Connection, number: int, until: int) -> set[int]:
    """Return the revisions of the edits that were undone at revision ``until``."""
    chosen = select(edits.c.kind, edits.c.target).where(
        edits.c.sequence == number, edits.c.revision <= until, edits.c.target.is_not(None)
    )
    undone: set[int] = set()
    for kind, target in connection.execute(chosen.order_by(edits.c.revision)):
        (undone.add if kind == "undo" else undone.discard)(target)
    return undone


def _moments(
    connection: Connection, which: ColumnElement[bool]
) -> list[tuple[int, int, list[dict[str, Any]]]]:
    """Return number, revision and palette of recordings from one query, hence consistent."""
    fields = [labels.c[name] for name in _FIELDS]
    chosen = (
        select(sequences.c.number, sequences.c.revision, *fields)
        .join(labels, labels.c.sequence == sequences.c.number, isouter=True)
        .where(which, LIVE)
    )
    palettes: dict[tuple[int, int], list[dict[str, Any]]] = {}
    for number, revision, *values in connection.execute(chosen):
        palette = palettes.setdefault((number, revision), [])
        if values[0] is not None:
            palette.append(dict(zip(_FIELDS, values, strict=True)))
    return [(number, revision, palette) for (number, revision), palette in palettes.items()]


def _moment(
    connection: Connection, number: int, revision: int, palette: list[dict[str, Any]]
) -> Moment:
    classes = read_names(connection)
    ordered = in_order(Label(**classes.read(entry)) for entry in palette)
    return Moment(number, revision, {label.id: label for label in ordered})


def _find(connection: Connection, version: str) -> Snapshot | None:
    row = connection.execute(select(versions).where(versions.c.id == version)).first()
    return None if row is None else _version(connection, row)


def _get(connection: Connection, project: str, version: str) -> Snapshot:
    wanted = and_(versions.c.id == version, versions.c.project == project)
    row = connection.execute(select(versions).where(wanted)).first()
    if row is None:
        raise NotFoundError(f"snapshot: expected one of {project!r}, got {version!r}")
    return _version(connection, row)


def _version(connection: Connection, row: Any) -> Snapshot:
    parts = (
        select(sequences.c.id, version_recordings.c.revision)
        .join(sequences, sequences.c.number == version_recordings.c.sequence)
        .where(version_recordings.c.version == row.id, LIVE)
        .order_by(sequences.c.id)
    )
    recordings = {row.id: row.revision for row in connection.execute(parts)}
    return Snapshot(row.id, row.name, time_of(row.created), row.author, recordings)
