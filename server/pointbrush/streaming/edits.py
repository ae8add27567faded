"""A viewer's edits, in the order they came: live strokes, undo, redo, tracking runs."""

from __future__ import annotations

import asyncio
import time

from pointbrush.errors import (
    BadInputError,
    ForbiddenError,
    PointbrushError,
    TooManyRequestsError,
)
from pointbrush.labels import Commit
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.viewer import Viewer
from pointbrush.work.strokes import LiveStroke

Edit = (
    messages.StrokeBegin
    | messages.StrokeSamples
    | messages.StrokeEnd
    | messages.Undo
    | messages.Redo
    | messages.Track
)
EDITS = (
    messages.StrokeBegin,
    messages.StrokeSamples,
    messages.StrokeEnd,
    messages.Undo,
    messages.Redo,
    messages.Track,
)
WAITING, WAITING_BYTES = 64, 1 << 20
"""Edits that may wait, and their bytes; a viewer that sends faster is read more slowly."""
LIVE_STROKES = 8
EDITORS = ("annotator", "reviewer", "admin")


class Editor:
    """Applies one viewer's edits one after another, in threads."""

    def __init__(self, viewer: Viewer, hub: Hub) -> None:
        self._viewer, self._hub = viewer, hub
        self._queue: asyncio.Queue[tuple[Edit, int]] = asyncio.Queue(WAITING)
        self._bytes, self._fewer = 0, asyncio.Event()
        self._live: dict[str, LiveStroke | Commit] = {}
        self._refused: dict[str, None] = {}

    async def put(self, edit: Edit, nbytes: int) -> None:
        """Queue an edit that came as ``nbytes``; waits while too much is queued."""
        while self._bytes >= WAITING_BYTES:
            self._fewer.clear()
            await self._fewer.wait()
        self._bytes += nbytes
        await self._queue.put((edit, nbytes))

    async def run(self) -> None:
        """Apply edits until cancelled."""
        while True:
            edit, nbytes = await self._queue.get()
            try:
                await self._apply(edit)
            except PointbrushError as error:
                self._drop(edit)
                self._viewer.refuse(error, edit.id)
            finally:
                self._bytes -= nbytes
                self._fewer.set()
                self._queue.task_done()

    async def idle(self) -> None:
        """Wait until every edit that was put has been answered."""
        await self._queue.join()

    def _drop(self, edit: Edit) -> None:
        self._live.pop(edit.id, None)
        if isinstance(edit, messages.StrokeBegin | messages.StrokeSamples):
            # The rest of a refused stroke is on its way; one answer is enough.
            self._refused[edit.id] = None
            if len(self._refused) > LIVE_STROKES * 8:
                del self._refused[next(iter(self._refused))]

    async def _apply(self, edit: Edit) -> None:
        if self._viewer.role not in EDITORS:
            raise ForbiddenError(
                f"expected the role annotator or higher, this token's is {self._viewer.role}"
            )
        match edit:
            case messages.StrokeBegin():
                await self._begin(edit)
            case messages.StrokeSamples() | messages.StrokeEnd() if edit.id in self._refused:
                if isinstance(edit, messages.StrokeEnd):
                    del self._refused[edit.id]
            case messages.StrokeSamples():
                await self._samples(edit)
            case messages.StrokeEnd():
                await self._end(edit)
            case messages.Undo() | messages.Redo():
                await self._undo(edit)
            case messages.Track():
                await self._track(edit)

    async def _begin(self, edit: messages.StrokeBegin) -> None:
        viewer = self._viewer
        workspace, sequence = self._hub.workspace, viewer.require_room().id
        self._refused.pop(edit.id, None)
        if len(self._live) >= LIVE_STROKES and edit.id not in self._live:
            raise TooManyRequestsError(f"expected at most {LIVE_STROKES} strokes at a time")

        def begin() -> LiveStroke | Commit:
            # A stroke that is sent again after its answer was lost has been applied.
            done = workspace.store.find(sequence, edit.id)
            return done or workspace.begin_stroke(
                sequence, edit.frame, edit.brush.model_dump(), edit.id
            )

        self._live[edit.id] = await self._hub.edit(begin)

    def _stroke(self, stroke_id: str) -> LiveStroke | Commit:
        if stroke_id not in self._live:
            raise BadInputError(f"id: expected a stroke that has begun, got {stroke_id}")
        return self._live[stroke_id]

    async def _samples(self, edit: messages.StrokeSamples) -> None:
        stroke = self._stroke(edit.id)
        if isinstance(stroke, Commit):
            return
        samples = [sample.model_dump() for sample in edit.samples]

        def add() -> tuple[int, int]:
            return stroke.add(samples), stroke.changing

        touched, changed = await self._hub.edit(add)
        self._answer(edit.id, stroke.frame, touched, changed=changed)

    async def _end(self, edit: messages.StrokeEnd) -> None:
        viewer = self._viewer
        started = time.monotonic()
        stroke = self._stroke(edit.id)
        if isinstance(stroke, Commit):
            commit, frame, touched = stroke, next(iter(stroke.frames), 0), stroke.changed
        else:
            commit = await self._hub.edit(stroke.commit, viewer.author)
            frame, touched = stroke.frame, stroke.touched
        del self._live[edit.id]
        self._hub.metrics.strokes.observe(time.monotonic() - started)
        self._answer(edit.id, frame, touched, commit)

    async def _undo(self, edit: messages.Undo | messages.Redo) -> None:
        viewer = self._viewer
        workspace = self._hub.workspace
        act = workspace.undo if isinstance(edit, messages.Undo) else workspace.redo
        sequence = viewer.require_room().id
        commit = await self._hub.edit(act, sequence, viewer.author, edit.id)
        self._answer(edit.id, next(iter(commit.frames), 0), commit.changed, commit)

    async def _track(self, edit: messages.Track) -> None:
        viewer = self._viewer
        sequence = viewer.require_room().id

        def start() -> None:
            self._hub.workspace.track(
                sequence,
                start=edit.start,
                stop=edit.stop,
                author=viewer.author,
                labels=edit.labels,
                method=edit.method,
                overwrite=edit.overwrite,
                continue_lost=edit.continue_lost,
                until_painted=edit.until_painted,
                stop_unsure=edit.stop_unsure,
                edit=edit.id,
            )

        await self._hub.edit(start)

    def _answer(
        self,
        stroke_id: str,
        frame: int,
        touched: int,
        commit: Commit | None = None,
        changed: int = 0,
    ) -> None:
        self._viewer.outbox.reply(
            encode(
                messages.StrokeResult(
                    id=stroke_id,
                    frame=frame,
                    touched=touched,
                    changed=commit.changed if commit else changed,
                    edit=commit.edit_id if commit else None,
                    revision=commit.revision if commit else self._viewer.require_room().revision,
                    final=commit is not None,
                )
            )
        )
