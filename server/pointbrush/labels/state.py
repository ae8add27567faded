"""State of one sequence in a process: palette, counts, blocks, all as of one revision."""

from __future__ import annotations

import threading
import zlib
from collections.abc import Container, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import Connection, Row, select

from pointbrush.database.class_names import ClassNames, read_names
from pointbrush.database.revisions import Found
from pointbrush.database.schema import (
    DROPPED,
    UNDONE,
    counts,
    edits,
    frame_changes,
    labels,
    sequences,
)
from pointbrush.errors import NotFoundError
from pointbrush.labels.blocks import Block, BlockCache, Place, block_size, load_blocks
from pointbrush.labels.classes.palette import in_order
from pointbrush.labels.packing import (
    BLOCK,
    DELETED_BIT,
    LABEL_BITS,
    LABELS,
    VALUE_BITS,
    Change,
    States,
)
from pointbrush.labels.types import Cell, Label

Count = tuple[int, int, int]
"""Points and painted points (both without deleted points), and all points that hold the label."""
FrameLabel = tuple[int, int]
NONE: Count = (0, 0, 0)
DELETION_RUN = 64
"""Number of blocks of the deletion layer that are read together."""


class NotInMemoryError(LookupError):
    """A block is not in memory, and there is no connection to read it."""


class SequenceState:
    """A cache of the database for one sequence; hold ``lock`` while using it."""

    def __init__(self, connection: Connection, row: Row[Any], blocks: BlockCache) -> None:
        self.lock = threading.RLock()
        self.stale = False
        """The state may differ from the database and must be read again."""
        self.classes = ClassNames()
        """Names of the classes of its labels."""
        self.palette: dict[int, Label] = {}
        self.counts: dict[FrameLabel, Count] = {}
        self.changed: dict[int, int] = {}
        """Revision of the last change by frame, for changed frames."""
        self._blocks = blocks
        self.reset(connection, row)

    def reset(self, connection: Connection, row: Row[Any]) -> None:
        """Read the whole state for the sequence's row."""
        self.number: int = row.number
        self.id: str = row.id
        self.identity: str | None = row.identity
        self.revision: int = row.revision
        self.highest_label = 0
        self.points = decode_points(row.points)
        self.exists = _only_unlabeled()
        self.locked = np.zeros(1 << 16, np.bool_)
        self.hidden = np.zeros(1 << 16, np.bool_)
        self.counts.clear()
        self.changed.clear()
        self._undone: set[int] | None = None  # read when first needed
        self.reload_palette(connection)
        self.reload_counts(connection)
        self.reload_changed(connection, 0)
        self.stale = False

    @property
    def known(self) -> Found:
        """Return the number, revision and class revision of this state."""
        return self.number, self.revision, self.classes.revision

    def undone(self, connection: Connection) -> set[int]:
        """Return the revisions of undone edits."""
        if self._undone is None:
            query = select(edits.c.revision).where(
                edits.c.sequence == self.number, edits.c.state.in_((UNDONE, DROPPED))
            )
            self._undone = set(connection.execute(query).scalars())
        return self._undone

    def turn(self, kind: str, target: int | None) -> None:
        """Update the undone edits for a committed undo or redo of ``target``."""
        if self._undone is not None and target is not None:
            (self._undone.add if kind == "undo" else self._undone.discard)(target)

    # ── palette and counts ───────────────────────────────────────────────────────────────

    def reload_palette(self, connection: Connection) -> None:
        """Read the palette and the highest id ever assigned, including deleted labels."""
        highest = select(sequences.c.highest_label).where(sequences.c.number == self.number)
        self.highest_label = connection.execute(highest).scalar_one()
        self.classes = read_names(connection)
        rows = connection.execute(select(labels).where(labels.c.sequence == self.number))
        self.set_palette(
            Label(
                row.id,
                row.name,
                self.classes.name(row.category),
                row.color,
                bool(row.locked),
                bool(row.visible),
                instance=row.instance,
                position=row.position,
            )
            for row in rows
        )

    def set_palette(self, palette: Iterable[Label]) -> None:
        """Set the palette and its lookup tables."""
        self.palette = {label.id: label for label in in_order(palette)}
        self.exists = exists_table(self.palette)
        self.locked = np.zeros(1 << 16, np.bool_)
        self.locked[[label.id for label in self.palette.values() if label.locked]] = True
        self.hidden = np.zeros(1 << 16, np.bool_)
        self.hidden[[label.id for label in self.palette.values() if not label.visible]] = True
        self.highest_label = max([self.highest_label, *self.palette])

    def reload_counts(self, connection: Connection) -> None:
        """Read the counts of all frames."""
        rows = connection.execute(select(counts).where(counts.c.sequence == self.number)).all()
        self.counts.update(
            {(row.frame, row.label): (row.points, row.painted, row.held) for row in rows}
        )

    def reload_changed(self, connection: Connection, after: int) -> None:
        """Read the last change of each frame that changed after revision ``after``."""
        table = frame_changes.c
        query = select(table.frame, table.revision).where(
            table.sequence == self.number, table.revision > after
        )
        self.changed.update((frame, last) for frame, last in connection.execute(query))

    def cell(self, key: FrameLabel) -> Cell:
        """Return the visible count of a label in a frame."""
        return cell_of(key, self.counts.get(key, NONE), self.palette)

    def counts_of(self, labels: Iterable[int]) -> dict[FrameLabel, Count]:
        """Return the counts of some labels in all frames."""
        wanted = set(labels)
        if not wanted:
            return {}
        return {key: count for key, count in self.counts.items() if key[1] in wanted}

    # ── points ───────────────────────────────────────────────────────────────────────────

    def frame_points(self, frame: int) -> int:
        """Return the number of points of a frame; raises NotFoundError."""
        if not 0 <= frame < len(self.points):
            raise NotFoundError(f"frame: expected 0 to {len(self.points) - 1}, got {frame}")
        return int(self.points[frame])

    def block(self, connection: Connection | None, place: Place) -> Block:
        """Return a block; raises NotInMemoryError if it must be read without a connection."""
        found = self._blocks.known((self.number, place))
        if found is not None:
            return found
        frame, layer, block = place
        if layer == LABELS:
            return self.block_run(connection, frame, layer, block, block)[0]
        # Deletions are rare, so one query for many blocks without any is cheap.
        first = block - block % DELETION_RUN
        last = min(first + DELETION_RUN, -(-self.frame_points(frame) // BLOCK)) - 1
        return self.block_run(connection, frame, layer, first, last)[block - first]

    def block_run(
        self, connection: Connection | None, frame: int, layer: int, first: int, last: int
    ) -> list[Block]:
        """Return blocks first..last of a frame; missing blocks are read with one query.

        Raises NotInMemoryError for missing blocks without a connection.
        """
        places = [(frame, layer, block) for block in range(first, last + 1)]
        found = [self._blocks.known((self.number, place)) for place in places]
        missing = [place[2] for place, block in zip(places, found, strict=True) if block is None]
        if missing:
            if connection is None:
                raise NotInMemoryError
            points = self.frame_points(frame)
            loaded = load_blocks(
                connection, self.number, frame, layer, missing[0], missing[-1], points
            )
            for block in missing:
                held = loaded.get(block) or Block(None, 0)
                found[block - first] = held
                self._blocks.keep(self.number, (frame, layer, block), held)
        return [block for block in found if block is not None]

    def adopt(self, changes: Mapping[Place, Change]) -> None:
        """Apply changes to blocks in memory."""
        for place in changes:
            block = self._blocks.known((self.number, place))
            if block is not None:
                block.apply(changes[place], block_size(self.frame_points(place[0]), place[2]))
                self._blocks.keep(self.number, place, block)

    def cached(self, place: Place) -> Block | None:
        """Return a block in memory, or None."""
        return self._blocks.known((self.number, place))

    def forget_blocks(self) -> None:
        """Drop all blocks and the undone edits from memory."""
        self._undone = None
        self._blocks.forget(self.number)


def visible(states: States, exists: NDArray[np.bool_]) -> States:
    """Return the value bits that users see: a label that is not in the palette is no label.

    Points keep the id of a deleted label in their word, so that undoing the deletion also restores
    points that were painted over at that time.
    """
    values = states & VALUE_BITS
    known = exists[(states & LABEL_BITS).astype(np.intp)]
    if not known.all():
        values = np.where(known, values, values & DELETED_BIT)
    return values


def cell_of(key: FrameLabel, count: Count, palette: Container[int]) -> Cell:
    """Return the count that users see: labels that are not in the palette have no points."""
    points, painted, _ = count if key[1] in palette else NONE
    return Cell(*key, points, painted)


def exists_table(palette: Iterable[int]) -> NDArray[np.bool_]:
    """Return for each number 0..65535 whether it is a visible label or 0."""
    table = _only_unlabeled()
    table[list(palette)] = True
    return table


def encode_points(points: Sequence[int]) -> bytes:
    """Encode points per frame for the database."""
    return zlib.compress(np.asarray(points, "<i8").tobytes(), 1)


def decode_points(data: bytes) -> NDArray[np.int64]:
    """Decode points per frame, (frames,)."""
    return np.frombuffer(zlib.decompress(data), "<i8")


def _only_unlabeled() -> NDArray[np.bool_]:
    table = np.zeros(1 << 16, np.bool_)
    table[0] = True
    return table
