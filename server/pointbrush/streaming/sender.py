"""The task that writes to a viewer: answers first, then edits, states, and points."""

from __future__ import annotations

import asyncio
from functools import partial

from pointbrush.errors import NotFoundError, PointbrushError, UnavailableError
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.plan import Unopened
from pointbrush.streaming.room import Room
from pointbrush.streaming.table import FrameTable, Piece
from pointbrush.streaming.viewer import Viewer

VALUES_RUN = 4_000_000
"""Most points of one message of values."""
RETRY_SECONDS = 0.5


class Sender:
    """Sends to one viewer until cancelled or the link breaks."""

    def __init__(self, viewer: Viewer, hub: Hub) -> None:
        self._viewer, self._hub = viewer, hub
        self._outbox = viewer.outbox
        self._states_time = float("-inf")
        self._idle = True

    async def run(self) -> None:
        """Send waiting messages and points; sleep while there are none."""
        points = True
        while True:
            # Looking for points takes longer than sending another viewer's edit.
            points = self._outbox.wake.clear() or points
            try:
                if not self._outbox.quiet:
                    await self._messages()
                points = points and await self._points()
                if not points:
                    await self._rest()
            except UnavailableError:
                # The database is unavailable: messages stay queued until it is back.
                await asyncio.sleep(RETRY_SECONDS)
            except PointbrushError as error:
                # The sequence was deleted, perhaps by another server, before its event arrived.
                self._hub.send_out(self._viewer, error)

    async def _rest(self) -> None:
        viewer = self._viewer
        pauses = [viewer.plan.wait(viewer.now()), self._states_pause()]
        known = [pause for pause in pauses if pause is not None]
        await self._outbox.wake.wait(min(known) if known else None)

    # ── everything but points ────────────────────────────────────────────────────────────

    async def _messages(self) -> None:
        outbox, send = self._outbox, self._viewer.send
        if outbox.replies:
            replies = list(outbox.replies)
            outbox.replies.clear()
            await self._viewer.send_each(replies)
        while outbox.jobs:
            await send(outbox.jobs.pop(next(iter(outbox.jobs))))
        await self._stale()
        await self._deltas()
        await self._states()
        while outbox.presence:
            await send(outbox.presence.pop(next(iter(outbox.presence))))

    async def _deltas(self, up_to: int | None = None) -> None:
        # No deltas before queued values: the newest delta sets the viewer's revision, and after a
        # lost connection the viewer would resume behind values that it never received.
        if not self._outbox.stale:
            deltas = []
            while (delta := self._outbox.next_delta(up_to)) is not None:
                deltas.append(delta.data)
            await self._viewer.send_each(deltas)

    async def _stale(self) -> None:
        while self._outbox.stale and (room := self._viewer.room) is not None:
            frame = next(iter(self._outbox.stale))
            try:
                await self._anew(room, frame)
            except UnavailableError:
                self._outbox.stale.setdefault(frame)
                raise
            except PointbrushError as error:
                self._outbox.stale.pop(frame, None)
                self._give_up(room, frame, error)

    async def _anew(self, room: Room, frame: int) -> None:
        """Send all values of a frame.

        Deltas that arrive while a large frame is sent wait and follow in order; applying a delta
        that a run already includes changes nothing.
        """
        runs = self._runs(frame, await room.stock.table(frame))
        # From here on the outbox takes deltas of this frame again, so that none is missed.
        self._outbox.stale.pop(frame, None)
        oldest = None
        for first, count in runs:
            revision, data = await room.values.message(frame, first, count)
            if self._viewer.room is not room:
                return  # the viewer has opened another sequence
            oldest = revision if oldest is None else oldest
            # Every run includes the edits of the first one.
            self._outbox.drop(frame, oldest)
            await self._viewer.send(data)

    def _runs(self, frame: int, table: FrameTable) -> list[tuple[int, int]]:
        """Return first point and length of each run of a frame that a viewer may have."""
        viewer, spans = self._viewer, [(0, table.firsts[-1])]
        if viewer.plan.large and not viewer.resumed:
            chunks = viewer.plan.chunks.get(frame)
            if chunks is not None:
                spans = table.spans(chunks)
        return [
            (first, min(VALUES_RUN, stop - first))
            for start, stop in spans
            for first in range(start, max(stop, start + 1), VALUES_RUN)
        ]

    def _states_pause(self) -> float | None:
        room = self._viewer.room
        outbox = self._outbox
        timeline = outbox.cells or outbox.all_cells
        changed = outbox.labels or timeline or outbox.boxes or outbox.all_boxes
        if room is None or not changed:
            return None
        return max(0.0, self._states_time + room.states_period - self._viewer.now())

    async def _states(self) -> None:
        viewer, outbox = self._viewer, self._outbox
        room = viewer.room
        pause = self._states_pause()
        if room is None or pause is None or pause > 0:
            return
        self._states_time = viewer.now()
        # Cleared before the read: later changes are sent the next time.
        labels, outbox.labels = outbox.labels, False
        cells = None if outbox.all_cells else frozenset(outbox.cells)
        outbox.cells, outbox.all_cells = set(), False
        boxes = None if outbox.all_boxes else frozenset(outbox.boxes)
        outbox.boxes, outbox.all_boxes = set(), False
        try:
            await room.board.refresh()
            made = []
            if labels:
                made.append(await room.board.labels_message(viewer.author))
            if cells is None or cells:
                made.append(await room.board.timeline_message(cells))
            if boxes is None or boxes:
                made.append(await room.board.boxes_message(boxes))
            await viewer.send_each(made)
        except UnavailableError:
            outbox.labels = outbox.labels or labels
            outbox.all_cells = outbox.all_cells or cells is None
            outbox.cells |= cells or frozenset()
            outbox.all_boxes = outbox.all_boxes or boxes is None
            outbox.boxes |= boxes or frozenset()
            raise

    # ── points ───────────────────────────────────────────────────────────────────────────

    async def _points(self) -> bool:
        """Send one piece; return False if there is none, or if the link is full."""
        viewer = self._viewer
        room, plan = viewer.room, viewer.plan
        if room is None or viewer.catching_up:
            # Missed deltas go first: they must not follow newer values.
            return False
        if not plan.link.has_room:
            self._idle = False
            return False
        piece = await self._next_piece(room)
        if piece is None:
            self._idle = True
            return False
        held = plan.held.get(piece.frame)
        await self._hub.load.turn()
        # The viewer may have opened another sequence or dropped the frame during the wait.
        same = viewer.room is room and viewer.plan is plan and not viewer.catching_up
        if same and plan.held.get(piece.frame) == held:
            try:
                await self._send_piece(room, piece)
            except UnavailableError:
                raise
            except PointbrushError as error:
                self._give_up(room, piece.frame, error)
        return True

    def _give_up(self, room: Room, frame: int, error: PointbrushError) -> None:
        """Report once to the viewer that a frame cannot be read; other frames are still sent.

        If the recording was deleted, report this instead and close it.
        """
        if self._viewer.room is not room:
            return
        if isinstance(error, NotFoundError) or room.recording.files.is_gone():
            self._hub.send_out(self._viewer, NotFoundError(room.id))
            return
        damaged = self._viewer.plan.damaged
        if frame not in damaged:
            damaged.add(frame)
            self._viewer.refuse(error)

    async def _next_piece(self, room: Room) -> Piece | None:
        """Return the plan's next piece; frames that the plan asks for are opened first."""
        viewer = self._viewer
        known = partial(room.stock.known_table, depth=viewer.depth)
        while viewer.room is room:
            chosen = viewer.plan.next(viewer.now(), known)
            if not isinstance(chosen, Unopened):
                return chosen
            try:
                await room.stock.table(chosen.frame)
            except UnavailableError:
                raise
            except PointbrushError as error:
                self._give_up(room, chosen.frame, error)
        return None

    async def _send_piece(self, room: Room, piece: Piece) -> None:
        viewer = self._viewer
        plan = viewer.plan
        anew, held = not viewer.has(piece.frame), plan.held.get(piece.frame)
        # From here on the outbox takes deltas of this frame, so that none is missed.
        self._hub.count_skipped_frames(plan.sent(piece, viewer.now()))
        try:
            ready = room.stock.ready(piece) or await room.stock.messages(piece)
        except PointbrushError:
            plan.unsent(piece, held)
            raise
        revision, values, (head, data) = ready
        nbytes = len(head) + len(data)
        if self._outbox.stale:
            # Queued values go first; the values of this piece are read again after them.
            plan.unsent(piece, held)
            return
        if anew:
            # The viewer has no values yet that a delta before these could apply to.
            self._outbox.drop(piece.frame, revision)
        else:
            # Older deltas go first, so that a viewer can apply messages in order of arrival.
            await self._deltas(revision)
        plan.sending(piece, anew=anew)
        for frame in plan.coming(piece):
            room.stock.expect(frame, plan.level, depth=viewer.depth)
        await viewer.send(head, data, before=values)
        plan.link.sent(nbytes, viewer.now(), idle=self._idle)
        self._idle = False
        self._hub.count_sent_frame(nbytes)
