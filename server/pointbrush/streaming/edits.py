"""A viewer's edits, in the order they came: live strokes, undo, redo, tracking runs."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import cast

from pointbrush.accounts.roles import require
from pointbrush.errors import (
    BadInputError,
    PointbrushError,
    TooManyRequestsError,
    UnauthorizedError,
)
from pointbrush.labels import Commit
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import decode, encode
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.roles import MESSAGES
from pointbrush.streaming.viewer import Viewer
from pointbrush.system.resources import shortages_as_unavailable
from pointbrush.values.runs import TrackingRequest
from pointbrush.work.annotate.strokes import LiveStroke
from pointbrush.work.objects.stroke import ObjectStroke

Edit = (
    messages.StrokeBegin
    | messages.StrokeSamples
    | messages.StrokeEnd
    | messages.StrokeCancel
    | messages.Undo
    | messages.Redo
    | messages.Track
)
WAITING, WAITING_BYTES = 1024, 12 << 20
"""Limits of a viewer's queue in edits and in bytes; above them, the socket is not read.

The limits hold an hour of strokes, because pings behind unread messages wait as well.
"""
TOGETHER = 8
TURN_SECONDS = 0.03
"""Time for edits of one viewer before other viewers have their turn."""
LONG_BYTES = 16 * 1024
"""Size from which on a message is decoded in a thread."""
LIVE_STROKES = 8
EXPEL_SECONDS = 0.5
"""Time between the answer to an edit of a revoked token and the close of its socket."""


@dataclass(frozen=True, slots=True)
class Applied:
    """Counts of an edit: touched points, and points that its commit changes or would change."""

    frame: int
    touched: int
    commit: Commit | None = None
    changed: int = 0


Result = Applied | PointbrushError | None
"""Outcome of an edit: counts, an error, or None if the edit needs no answer yet."""


Done = tuple[Edit, Result, float]
"""An edit, its outcome, and its time of arrival."""


@dataclass(frozen=True, slots=True)
class Waiting:
    """An edit in the queue, encoded if it is large; ``came``: its time of arrival."""

    edit: Edit | bytes
    nbytes: int
    came: float


def take_turn(work: Iterator[None]) -> bool:
    """Run work for one turn or until it is done; return whether it is done."""
    end = time.monotonic() + TURN_SECONDS
    return all(time.monotonic() < end for _ in work)


class Editor:
    """Applies one viewer's edits one after another, in threads, a turn at a time."""

    def __init__(self, viewer: Viewer, hub: Hub) -> None:
        self._viewer, self._hub = viewer, hub
        self._queue: asyncio.Queue[Waiting] = asyncio.Queue(WAITING)
        self._bytes, self._fewer = 0, asyncio.Event()
        self._live: dict[str, LiveStroke | ObjectStroke | Commit] = {}
        self._refused: dict[str, None] = {}

    async def put(self, edit: Edit, data: bytes) -> None:
        """Queue an edit that arrived as ``data``; wait while this viewer's queue is full.

        Raises TooManyRequestsError for a new stroke while the queues of all viewers are full.
        """
        if isinstance(edit, messages.StrokeBegin) and self._hub.load.overloaded:
            self._drop(edit)  # with its later messages
            raise TooManyRequestsError(
                f"expected at most {self._hub.load.most_waiting:,} waiting edits, got more: the "
                "server is overloaded, paint this again in a moment"
            )
        while self._bytes >= WAITING_BYTES:
            self._fewer.clear()
            await self._fewer.wait()
        self._bytes += len(data)
        # Large edits wait encoded: as objects they take ten times the memory.
        waiting = Waiting(data if len(data) > LONG_BYTES else edit, len(data), time.monotonic())
        await self._queue.put(waiting)
        self._hub.load.waiting += 1

    @property
    def waiting(self) -> int:
        """Edits that wait for their turn."""
        return self._queue.qsize()

    async def run(self) -> None:
        """Apply edits until cancelled.

        Waiting edits are applied together: a short stroke consists of three messages, and each
        call of a thread waits for the event loop twice.
        """
        try:
            while True:
                await self._apply_next()
        finally:
            self._hub.load.waiting -= self._queue.qsize()

    async def _apply_next(self) -> None:
        batch = [await self._queue.get()]
        while len(batch) < TOGETHER and not self._queue.empty():
            batch.append(self._queue.get_nowait())
        try:
            await self._apply_all(batch)
        finally:
            self._bytes -= sum(one.nbytes for one in batch)
            self._fewer.set()
            self._hub.load.waiting -= len(batch)
            for _ in batch:
                self._queue.task_done()

    async def _apply_all(self, batch: list[Waiting]) -> None:
        """Apply edits; answer each edit after the turn that finished it."""
        done: list[Done] = []
        work, finished, continued = self._work(batch, done), False, False
        while not finished:
            finished = await self._hub.edit(take_turn, work, continued=continued)
            continued = True
            for edit, result, came in done:
                self._send_result(edit, result)
                if isinstance(edit, messages.StrokeEnd):
                    self._hub.metrics.strokes.observe(time.monotonic() - came)
            done.clear()

    async def idle(self) -> None:
        """Wait until every queued edit has been answered."""
        await self._queue.join()

    def _drop(self, edit: Edit) -> None:
        self._live.pop(edit.id, None)
        if isinstance(edit, messages.StrokeBegin | messages.StrokeSamples):
            # Further messages of a refused stroke are on their way; one answer is enough.
            self._refused[edit.id] = None
            if len(self._refused) > LIVE_STROKES * 8:
                del self._refused[next(iter(self._refused))]

    def _send_result(self, edit: Edit, result: Result) -> None:
        if isinstance(result, PointbrushError):
            self._viewer.refuse(result, edit.id)
            if isinstance(result, UnauthorizedError):
                # The answer must leave before the socket is closed.
                asyncio.get_running_loop().call_later(EXPEL_SECONDS, self._viewer.expel)
        elif result is not None:
            self._answer(edit.id, result)

    # ── in a thread, one batch at a time ─────────────────────────────────────────────────

    def _work(self, batch: list[Waiting], done: list[Done]) -> Iterator[None]:
        """Apply edits and record each outcome; yield after each step, so that a turn can end."""
        expelled = self._admission_error()
        ends: set[str] = set()
        if self._hub.load.behind:
            ends = {one.edit.id for one in batch if isinstance(one.edit, messages.StrokeEnd)}
        for one in batch:
            edit = cast(Edit, decode(one.edit)) if isinstance(one.edit, bytes) else one.edit
            try:
                if expelled is not None:
                    raise expelled
                with shortages_as_unavailable():
                    # If the stroke's end waits already, its final answer replaces this one.
                    result = yield from self._apply(edit, provisional=edit.id not in ends)
                done.append((edit, result, one.came))
            except PointbrushError as error:
                self._drop(edit)
                done.append((edit, error, one.came))
            yield

    def _admission_error(self) -> UnauthorizedError | None:
        """Return an error if the viewer's token was revoked or has expired."""
        try:
            self._viewer.require_admitted()
        except UnauthorizedError as error:
            return error
        except PointbrushError:
            pass  # the database is unavailable: applying the edit reports it
        return None

    def _apply(self, edit: Edit, *, provisional: bool) -> Generator[None, None, Applied | None]:
        """Apply an edit; ``provisional``: report the points that a stroke has touched so far."""
        require(self._viewer.role, MESSAGES[edit.type])
        match edit:
            case messages.StrokeBegin():
                self._begin(edit)
            case messages.StrokeSamples() | messages.StrokeEnd() if edit.id in self._refused:
                if isinstance(edit, messages.StrokeEnd):
                    del self._refused[edit.id]
            case messages.StrokeSamples():
                return (yield from self._samples(edit, provisional=provisional))
            case messages.StrokeEnd():
                return self._end(edit)
            case messages.StrokeCancel():
                self._live.pop(edit.id, None)
                self._refused.pop(edit.id, None)
            case messages.Undo() | messages.Redo():
                return self._undo(edit)
            case messages.Track():
                self._track(edit)
        return None

    def _begin(self, edit: messages.StrokeBegin) -> None:
        workspace, sequence = self._hub.workspace, self._viewer.require_room().id
        self._refused.pop(edit.id, None)
        if len(self._live) >= LIVE_STROKES and edit.id not in self._live:
            raise TooManyRequestsError(f"expected at most {LIVE_STROKES} strokes at a time")
        self._live[edit.id] = workspace.strokes.begin(
            sequence, edit.frame, edit.brush.model_dump(), edit.id
        )

    def _stroke(self, stroke_id: str) -> LiveStroke | ObjectStroke | Commit:
        if stroke_id not in self._live:
            raise BadInputError(f"id: expected a stroke that has begun, got {stroke_id}")
        return self._live[stroke_id]

    def _samples(
        self, edit: messages.StrokeSamples, *, provisional: bool
    ) -> Generator[None, None, Applied | None]:
        stroke = self._stroke(edit.id)
        if isinstance(stroke, Commit):
            return None
        yield from stroke.adding([sample.model_dump() for sample in edit.samples])
        if not provisional:
            return None
        return Applied(stroke.frame, stroke.touched, changed=stroke.changing)

    def _end(self, edit: messages.StrokeEnd) -> Applied:
        stroke = self._stroke(edit.id)
        if isinstance(stroke, Commit):
            applied = Applied(next(iter(stroke.frames), 0), stroke.changed, stroke)
        else:
            if edit.touched is not None:
                if isinstance(stroke, ObjectStroke):
                    raise BadInputError("touched: expected none of an object, got points")
                stroke.replace([(one.frame, one.runs) for one in edit.touched])
            commit = stroke.commit(self._viewer.author)
            applied = Applied(stroke.frame, stroke.touched, commit)
        del self._live[edit.id]
        return applied

    def _undo(self, edit: messages.Undo | messages.Redo) -> Applied:
        viewer, workspace = self._viewer, self._hub.workspace
        act = workspace.labels.undo if isinstance(edit, messages.Undo) else workspace.labels.redo
        commit = act(viewer.require_room().id, viewer.author, edit.id)
        return Applied(next(iter(commit.frames), 0), commit.changed, commit)

    def _track(self, edit: messages.Track) -> None:
        viewer = self._viewer
        room, body = viewer.require_room(), TrackingRequest.of(edit)
        self._hub.workspace.tracking.start(room.id, body, viewer.author)

    # ── on the event loop ────────────────────────────────────────────────────────────────

    def _answer(self, edit_id: str, applied: Applied) -> None:
        room, commit = self._viewer.room, applied.commit
        revision = commit.revision if commit else room.revision if room else 0
        self._viewer.outbox.reply(
            encode(
                messages.StrokeResult(
                    id=edit_id,
                    frame=applied.frame,
                    touched=applied.touched,
                    changed=commit.changed if commit else applied.changed,
                    edit=commit.edit if commit else None,
                    revision=revision,
                    final=commit is not None,
                )
            )
        )
