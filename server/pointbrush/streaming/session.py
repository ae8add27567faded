"""One viewer's session: reads its messages, follows its clock, and sends its frames.

A session has four tasks: the caller's task calls ``receive``; one sends, so that messages keep
their order; one applies edits in order of arrival, so that a slow commit delays no credit; one
answers the newest ``ask`` message.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, get_args

from pointbrush import __version__
from pointbrush.accounts.accounts import MARK, OWNER, require_name
from pointbrush.accounts.roles import require
from pointbrush.database.job import Job
from pointbrush.errors import (
    BadInputError,
    NotFoundError,
    PointbrushError,
    ReadOnlyError,
    UnauthorizedError,
    UnavailableError,
)
from pointbrush.streaming import messages
from pointbrush.streaming.edits import LONG_BYTES, Edit, Editor
from pointbrush.streaming.encoding import check, decode, encode, unpack
from pointbrush.streaming.hub import Hub, compiling
from pointbrush.streaming.plan import Plan, PlayClock
from pointbrush.streaming.requests import PreviewRequests, of_this_import, sequence_info
from pointbrush.streaming.roles import MESSAGES
from pointbrush.streaming.room import Room
from pointbrush.streaming.sender import Sender
from pointbrush.streaming.viewer import CREDITS, Send, SendEach, Viewer
from pointbrush.work.annotate.overlays import require_overlaid

MESSAGES_PER_TURN = 8
"""Messages of one viewer that are handled in one iteration of the event loop."""
SLOW = ("hello", "open", *(edit.model_fields["type"].default for edit in get_args(Edit)))
"""Types of messages that wait for files, the database, or each other."""


@dataclass(frozen=True)
class Admitted:
    """A person with access, and the checks of this access."""

    author: str
    """Account of the person's edits."""
    name: str
    """Displayed name."""
    role: messages.Role
    shared: bool
    """Several people may use the token, and ``hello`` sets the displayed name."""
    require_admitted: Callable[[], None]
    """Raises UnauthorizedError once the token is not valid."""
    role_in: Callable[[str], messages.Role | None] | None = None
    """Returns the role in a recording, or None without access; default: ``role``."""
    sees: Callable[[Job], bool] = lambda _: True
    """Returns whether the person may see a job; default: every job."""


class ViewerSession(Viewer):
    """A viewer and the handlers of its messages."""

    def __init__(
        self, hub: Hub, send: Send, admitted: Admitted, send_each: SendEach | None = None
    ) -> None:
        super().__init__(
            send,
            author=admitted.author,
            role=admitted.role,
            load=hub.load,
            send_each=send_each,
            public=hub.workspace.paths.hide,
        )
        self.hub, self._shared, self.name = hub, admitted.shared, admitted.name
        self._require_admitted, self._sees = admitted.require_admitted, admitted.sees
        self._role_in = admitted.role_in or (lambda _: admitted.role)
        self.expelled = False
        """The viewer's token is no longer valid."""
        self.closing = asyncio.Event()
        self._editor = Editor(self, hub)
        self._previews = PreviewRequests(self, hub)
        self._draining = False
        self._handling = False
        """A slow message is being handled; later ones wait."""
        self._handlers: dict[type, Callable[[Any], None]] = {
            messages.Play: self._play,
            messages.Pause: self._pause,
            messages.Seek: self._seek,
            messages.Credit: self._credit,
            messages.Forget: self._forget,
            messages.Want: self._want,
            messages.ClientPresence: self._presence,
            messages.Ask: self._previews.put,
        }

    # ── life ─────────────────────────────────────────────────────────────────────────────

    async def run(self, receive: Callable[[], Awaitable[bytes | None]]) -> None:
        """Serve until ``receive`` returns None, the connection ends, or the server closes."""
        self.hub.join(self)
        tasks = [
            asyncio.create_task(self._listen(receive)),
            asyncio.create_task(self._editor.run()),
            asyncio.create_task(self._previews.run()),
            asyncio.create_task(Sender(self, self.hub).run()),
            asyncio.create_task(self.closing.wait()),
        ]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.gather(*tasks, return_exceptions=True)
            self.hub.leave(self)

    async def drain(self) -> None:
        """Read no more messages and answer the received ones, before the server stops."""
        self._draining = True
        await self._editor.idle()
        while self.outbox.replies:
            await asyncio.sleep(0.005)

    def close(self) -> None:
        """End the session: the server stops."""
        self.closing.set()

    def may_see(self, job: Job) -> bool:
        """See Viewer."""
        return self._sees(job)

    def require_admitted(self) -> None:
        """Raise UnauthorizedError once the viewer's token is not valid."""
        self._require_admitted()
        room = self.room
        if room is not None and self._role_in(room.id) != self.role:
            raise UnauthorizedError("expected the role that this recording was opened with")

    def expel(self) -> None:
        """End the session, because its token is no longer valid."""
        self.expelled = True
        self.closing.set()

    async def _listen(self, receive: Callable[[], Awaitable[bytes | None]]) -> None:
        count = 0
        while (data := await receive()) is not None:
            if self._draining:
                continue  # not answered, so that the page sends it again to the next server
            self._handling = True
            await self.receive(data)
            self._handling = False
            count += 1
            if count % MESSAGES_PER_TURN == 0:
                # Thousands of small messages can arrive at once: let other viewers have a turn.
                await asyncio.sleep(0)
            while self.outbox.crowded:
                # Read no further messages until the viewer reads its answers.
                await asyncio.sleep(0.05)

    def on_message(self, data: bytes) -> bool:
        """Handle a message at once and return True, or leave it to ``run``'s ``receive``.

        Slow messages, and all messages after them, wait for their turn there.
        """
        if self._draining or self._handling or self.outbox.crowded:
            return False
        try:
            content = unpack(data)
            if content.get("type") in SLOW:
                return False
            self._handle(check(content))
        except PointbrushError as error:
            self.refuse(error)
        return True

    async def receive(self, data: bytes) -> None:
        """Handle one message; answer an invalid one with ``error``."""
        about = None
        try:
            long = len(data) > LONG_BYTES
            message = await self.hub.read(decode, data) if long else decode(data)
            if isinstance(message, Edit):
                about = message.id
                await self._editor.put(message, data)
            elif isinstance(message, messages.Hello):
                require(self.role, MESSAGES[message.type])
                await self._hello(message)
            elif isinstance(message, messages.Open):
                require(self.role, MESSAGES[message.type])
                await self._open(message)
            else:
                self._handle(message)
        except PointbrushError as error:
            self.refuse(error, about)

    def _handle(self, message: messages.ClientMessage) -> None:
        """Handle a message; a refusal contains the message's id, if it has one."""
        try:
            require(self.role, MESSAGES[message.type])
            self._handlers[type(message)](message)
        except PointbrushError as error:
            self.refuse(error, getattr(message, "id", None))

    # ── its room ─────────────────────────────────────────────────────────────────────────

    @property
    def waiting_edits(self) -> int:
        """See ``Viewer``."""
        return self._editor.waiting

    async def reopen(self) -> None:
        """Open the sequence again after its manifest or import changed, or after its deletion."""
        old = self.room
        if old is None:
            return
        try:
            self.room = room = await self.hub.enter(self, old.id)
        except PointbrushError as error:
            self.hub.send_out(self, error)
            return
        if room is old:
            return
        if room.recording.placement != old.recording.placement:
            self._begin(room, min(self.plan.focus, len(room.recording) - 1))
            self.outbox.mark_all()
        self.outbox.reply(encode(sequence_info(room, self.plan.focus)))
        self.outbox.wake.set()

    def _begin(self, room: Room, frame: int) -> None:
        """Start a sequence of which the viewer has no data."""
        self.outbox.restart()
        old, large = self.plan, room.recording.manifest.large
        self.plan = Plan(
            len(room.recording), old.link, old.load, old.page, focus=frame, large=large
        )
        self.resumed = False

    # ── messages ─────────────────────────────────────────────────────────────────────────

    async def _hello(self, message: messages.Hello) -> None:
        if message.name and self._shared:
            await self.hub.read(self._choose_name, message.name)
        self.color, self.depth = message.color or self.color, message.depth
        self.outbox.reply(
            encode(
                messages.Welcome(
                    viewer=self.id,
                    author=self.name,
                    role=self.role,
                    version=__version__,
                    credits=CREDITS,
                    account=self.author,
                )
            )
        )
        for step, progress in self.hub.workspace.loops.missing().items():
            self.outbox.reply(compiling(step, progress))

    def _choose_name(self, name: str) -> None:
        """Set the displayed name of a user of the server's shared token; in a thread."""
        if self.author.partition(MARK)[0] == OWNER:
            # These users share an account: the name distinguishes them, and is not an account.
            require_name(name)
            self.author = f"{OWNER}{MARK}{name}"
        else:
            with contextlib.suppress(ReadOnlyError):  # a read-only workspace keeps no names
                self.hub.workspace.labels.accounts.rename(self.author, name)
        self.name = name

    async def _open(self, message: messages.Open) -> None:
        role = await self.hub.read(self._role_in, message.sequence)
        if role is None:
            raise NotFoundError(f"sequence: expected a known id, got {message.sequence!r}")
        message = await of_this_import(self.hub, message)
        room = await self.hub.enter(self, message.sequence)
        resuming = self.room is room and message.revision is not None
        self.room, self.role = room, role
        frames = len(room.recording)
        frame = min(message.frame, frames - 1)
        if not resuming:
            self._begin(room, frame)
            held = message.held or []
            self.plan.held = {frame: chunks for frame, chunks in held if frame < frames}
            self.resumed = message.revision is not None and message.held is None
        self.plan.focus, self.plan.wanted = frame, (frame, [])
        self.outbox.reply(encode(sequence_info(room, self.plan.focus)))
        self.outbox.mark_all()
        self.outbox.presence.update(self.hub.presence.messages_in(room.id))
        with contextlib.suppress(UnavailableError):  # then the next change of a job sends it
            for job in self.hub.workspace.jobs.all():
                if job.state in ("queued", "running"):
                    await self.hub.send_job(job, [self])
        if message.revision is not None:
            await self._catch_up(room, message.revision)
        self.outbox.wake.set()

    async def _catch_up(self, room: Room, revision: int) -> None:
        """Queue the deltas since ``revision``, or all values if it is too far back."""
        self.outbox.clear_deltas()
        # Commits that arrive during the read are queued in order with the others.
        self.catching_up = True
        try:
            deltas = await room.since(revision)
        except UnavailableError:
            deltas = None  # the database is unavailable: queue all values until it is back
        finally:
            self.catching_up = False
        if deltas is None:
            self.mark_all_stale()
            return
        for delta in deltas:
            if self.has(delta.frame):
                self.outbox.delta(delta)

    def _require_frame(self, frame: int) -> int:
        room = self.require_room()
        if frame >= len(room.recording):
            raise BadInputError(f"frame: expected 0 to {len(room.recording) - 1}, got {frame}")
        return frame

    def _play(self, message: messages.Play) -> None:
        frame = self._require_frame(message.frame)
        manifest = self.require_room().recording.manifest
        rate = manifest.fps * message.speed
        self.plan.play(PlayClock(frame, self.now(), rate, manifest.frames, message.loop))
        self.outbox.wake.set()

    def _pause(self, message: messages.Pause) -> None:
        frame = None if message.frame is None else self._require_frame(message.frame)
        self.require_room()
        self.plan.pause(frame, self.now())
        self.outbox.wake.set()

    def _seek(self, message: messages.Seek) -> None:
        around = [self._require_frame(frame) for frame in message.around]
        require_overlaid(self.require_room().recording, message.frame, around)
        self.plan.seek(self._require_frame(message.frame), around)
        self.outbox.wake.set()

    def _credit(self, message: messages.Credit) -> None:
        now, link, page = self.now(), self.plan.link, self.plan.page
        waited, requested = not link.has_room, page.requested_points
        link.credited(message.frames, now)
        page.report(
            message.frame_ms, message.target_ms, message.points, self.plan.shown_points, now
        )
        if waited or page.requested_points != requested:
            # Otherwise the sender sleeps for another reason, which still holds.
            self.outbox.wake.set()

    def _forget(self, message: messages.Forget) -> None:
        self.plan.forget(message.frames)
        self.outbox.wake.set()

    def _want(self, message: messages.Want) -> None:
        self.plan.wanted = self._require_frame(message.frame), list(message.chunks)
        self.outbox.wake.set()

    def _presence(self, message: messages.ClientPresence) -> None:
        room = self.require_room()
        fields = message.model_dump(exclude={"type"})
        self.hub.presence.put(
            room.id,
            messages.ServerPresence(
                viewer=self.id, name=self.name, color=self.color, left=False, **fields
            ),
        )
