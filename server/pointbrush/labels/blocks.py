"""Blocks of point states: a bounded cache in memory, and reading blocks from the database."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import ColumnElement, Connection, Table, and_, bindparam, select

from pointbrush.cache import Cache
from pointbrush.database.schema import edit_blocks, snapshots
from pointbrush.labels.packing import BLOCK, Change, States, decode_change, decode_states

Place = tuple[int, int, int]
"""Frame, layer, block."""
SNAPSHOT_EVERY = 64
"""Edits of a block between two snapshots, which bounds the time to read it."""
CACHE_BYTES = 256 << 20
ENTRY_BYTES = 512
"""Memory overhead of a cached block, bytes."""


@dataclass(slots=True, eq=False)
class Block:
    """States of one block; ``states`` None: all zero.  ``age``: edits since its snapshot."""

    states: States | None
    age: int
    queued: bool = False
    """A snapshot of the block is queued."""

    def words(self, indices: np.ndarray[tuple[int], np.dtype[np.int64]]) -> States:
        """Return a copy of the words at ``indices``."""
        if self.states is None:
            return np.zeros(len(indices), np.uint64)
        return self.states[indices]

    def apply(self, change: Change, size: int) -> None:
        """Apply an edit's change to this block of ``size`` points."""
        if self.states is None:
            self.states = np.zeros(size, np.uint64)
        self.states[change.indices] = change.after
        self.age += 1


class BlockCache(Cache[tuple[int, Place], Block]):
    """The most recently used blocks of all sequences, by sequence number and place."""

    def keep(self, number: int, place: Place, block: Block) -> None:
        """Cache a block, or update its size."""
        states = 0 if block.states is None else block.states.nbytes
        self.put((number, place), block, ENTRY_BYTES + states)

    def forget(self, number: int) -> None:
        """Forget all blocks of a sequence."""
        self.drop(*(key for key in self.held() if key[0] == number))


def block_size(points: int, block: int) -> int:
    """Return the number of points in block ``block`` of a frame of ``points``."""
    return min(BLOCK, points - block * BLOCK)


def _of_frame(table: Table) -> ColumnElement[bool]:
    return and_(
        table.c.sequence == bindparam("of_sequence"),
        table.c.frame == bindparam("frame"),
        table.c.layer == bindparam("layer"),
    )


_SNAPSHOTS = select(snapshots.c.block, snapshots.c.revision, snapshots.c.data).where(
    _of_frame(snapshots), snapshots.c.block.between(bindparam("first"), bindparam("last"))
)
_JOURNAL = select(edit_blocks.c.block, edit_blocks.c.data).where(_of_frame(edit_blocks))
_WHOLE = _JOURNAL.where(
    edit_blocks.c.block.between(bindparam("first"), bindparam("last"))
).order_by(edit_blocks.c.block, edit_blocks.c.revision)
# One block per query, by equality: for a range, or a join with the snapshots, the database would
# scan the whole history of each block.
_SINCE = _JOURNAL.where(
    edit_blocks.c.block == bindparam("block"), edit_blocks.c.revision > bindparam("after")
).order_by(edit_blocks.c.revision)


def load_blocks(
    connection: Connection, number: int, frame: int, layer: int, first: int, last: int, points: int
) -> dict[int, Block]:
    """Read blocks first..last of a frame from their snapshots and the later journal.

    The result lacks blocks without edits.
    """
    place = {"of_sequence": number, "frame": frame, "layer": layer}
    blocks: dict[int, Block] = {}
    later: list[Any] = []
    for block, revision, data in connection.execute(
        _SNAPSHOTS, {**place, "first": first, "last": last}
    ).all():
        blocks[block] = Block(decode_states(data), 0)
        later += connection.execute(_SINCE, {**place, "block": block, "after": revision}).all()
    for start, stop in _gaps(first, last, sorted(blocks)):
        later += connection.execute(_WHOLE, {**place, "first": start, "last": stop}).all()
    for block, data in later:
        held = blocks.setdefault(block, Block(None, 0))
        held.apply(decode_change(data), block_size(points, block))
    return blocks


def _gaps(first: int, last: int, present: list[int]) -> Iterator[tuple[int, int]]:
    """Yield the runs of first..last between the numbers in ``present``."""
    for before, after in itertools.pairwise([first - 1, *present, last + 1]):
        if after - before > 1:
            yield before + 1, after - 1
