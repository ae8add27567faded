"""All viewers of one server: rooms by sequence, the workspace's events, presence, load."""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from typing import Any, TypeVar

import anyio
import anyio.to_thread

from pointbrush.database.job import Job
from pointbrush.errors import NotFoundError, PointbrushError, UnavailableError
from pointbrush.labels import Commit
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.load import Load
from pointbrush.streaming.metrics import Metrics
from pointbrush.streaming.room import Room
from pointbrush.streaming.shared.cache import MessageCache
from pointbrush.streaming.shared.presence import Presence
from pointbrush.streaming.shared.stock import Shelf
from pointbrush.streaming.viewer import Viewer
from pointbrush.system.resources import shortages_as_unavailable
from pointbrush.work.events import (
    ClassesRenamed,
    Compiling,
    Event,
    Prepared,
    Provisional,
    Retracted,
    SequencesChanged,
)
from pointbrush.work.loops.compiling import Progress, StepName
from pointbrush.workspace import Workspace

logger = logging.getLogger(__name__)

T = TypeVar("T")
VALUES_BYTES = 32 * 2**20
"""Memory for values of frames, run-length encoded; an unlabelled frame takes 1 kB."""
READ_THREADS, EDIT_THREADS, LONG_THREADS = 4, 8, 2
PRESENCE_HZ = 30.0
RESEND_SECONDS = 1.0
"""Pause before the state of a job is sent again after the database was unavailable."""


def compiling(step: StepName, progress: Progress) -> bytes:
    """Return the message about a step of compiling loops."""
    return encode(messages.Compiling(step=step, share=progress.share, seconds=progress.seconds))


class Hub:
    """Connects viewers with the workspace."""

    def __init__(self, workspace: Workspace, metrics: Metrics) -> None:
        self.workspace, self.metrics = workspace, metrics
        self.values, self.shelf = MessageCache(VALUES_BYTES), Shelf()
        self.viewers: set[Viewer] = set()
        self.rooms: dict[str, Room] = {}
        self.presence = Presence()
        self.load = Load(workspace.settings.waiting_edits)
        self._frames = self._bytes = self._skipped = 0
        self._counted = (0, 0, 0)
        self._opening = asyncio.Lock()
        self._events: asyncio.Queue[Event] = asyncio.Queue()
        self._unsent_jobs: dict[str, Job] = {}
        self._reads = anyio.CapacityLimiter(READ_THREADS)
        self._edits = anyio.CapacityLimiter(EDIT_THREADS)
        self._long = anyio.CapacityLimiter(LONG_THREADS)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[Hub]:
        """Forward the workspace's events while the context is open; then close all viewers."""
        loop = asyncio.get_running_loop()

        def forward(event: Event) -> None:
            # Called from any thread, possibly while the loop ends.
            if isinstance(event, Job):
                self.metrics.job(event)
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._events.put_nowait, event)

        unsubscribe = self.workspace.subscribe(forward)
        self.metrics.watch_queues(self.queue_lengths)
        self.workspace.labels.time_transactions(self.metrics.transaction)
        try:
            async with asyncio.TaskGroup() as tasks:
                background = [
                    tasks.create_task(self._dispatch_all()),
                    tasks.create_task(self._relay_presence()),
                    tasks.create_task(self.load.watch(self._sent_bytes, self._followers)),
                ]
                yield self
                for viewer in list(self.viewers):
                    viewer.close()
                for task in background:
                    task.cancel()
        finally:
            unsubscribe()

    async def drain(self, seconds: float) -> None:
        """Answer the received edits and read no new ones, for at most ``seconds``."""
        answers = [asyncio.create_task(viewer.drain()) for viewer in self.viewers]
        if answers:
            _, late = await asyncio.wait(answers, timeout=seconds)
            for task in late:
                task.cancel()

    async def read(self, function: Callable[..., T], *args: Any) -> T:
        """Run a short function that reads in a thread."""
        with shortages_as_unavailable():
            return await anyio.to_thread.run_sync(function, *args, limiter=self._reads)

    async def edit(self, function: Callable[..., T], *args: Any, continued: bool = False) -> T:
        """Run a function that writes in a thread of a separate pool, so that readers do not wait.

        ``continued``: continue long work in the pool for long work; short edits keep their threads.
        """
        if continued:
            with shortages_as_unavailable():
                return await anyio.to_thread.run_sync(function, *args, limiter=self._long)
        with self.load.edit(), shortages_as_unavailable():
            return await anyio.to_thread.run_sync(function, *args, limiter=self._edits)

    # ── sent messages ────────────────────────────────────────────────────────────────────

    def count_sent_frame(self, nbytes: int) -> None:
        """Count a frame message that was sent."""
        self._frames += 1
        self._bytes += nbytes

    def count_skipped_frames(self, frames: int) -> None:
        """Count frames that a playing viewer did not receive."""
        self._skipped += frames

    def _sent_bytes(self) -> int:
        """Return the bytes sent so far, and add the difference to the metrics in one step."""
        self.metrics.frames.inc(self._frames - self._counted[0])
        self.metrics.sent.inc(self._bytes - self._counted[1])
        self.metrics.skipped.inc(self._skipped - self._counted[2])
        self._counted = self._frames, self._bytes, self._skipped
        return self._bytes

    def _followers(self) -> int:
        return sum(viewer.plan.clock is not None for viewer in self.viewers)

    def queue_lengths(self) -> dict[str, int]:
        """Return the numbers of waiting edits and events, and of this server's jobs."""
        jobs = Counter(job.state for job in self.workspace.runner.known.all())
        return {
            "edits": sum(viewer.waiting_edits for viewer in list(self.viewers)),
            "events": self._events.qsize(),
            "jobs_queued": jobs["queued"],
            "jobs_running": jobs["running"],
        }

    # ── viewers ──────────────────────────────────────────────────────────────────────────

    def join(self, viewer: Viewer) -> None:
        """Add a viewer when its socket opens."""
        self.viewers.add(viewer)
        self.metrics.viewers.set(len(self.viewers))

    def leave(self, viewer: Viewer) -> None:
        """Remove a viewer when its socket closes."""
        self.viewers.discard(viewer)
        self.metrics.viewers.set(len(self.viewers))
        self.exit(viewer)

    async def enter(self, viewer: Viewer, sequence: str) -> Room:
        """Add a viewer to a sequence's room; raise NotFoundError."""
        recording = await self.read(self.workspace.recording, sequence)
        async with self._opening:
            old = room = self.rooms.get(sequence)
            if room is None or room.recording is not recording:
                room = Room(self.workspace, recording, self.values, self.shelf, self.read)
                self.rooms[sequence] = room
                try:
                    await room.load()
                except BaseException:
                    del self.rooms[sequence]
                    raise
                if old is not None:
                    room.viewers |= old.viewers
                    # Another server that changes a recording sends no event to this one.
                    self._events.put_nowait(SequencesChanged(sequence))
        if viewer.room is not room:
            self.exit(viewer)
        room.viewers.add(viewer)
        return room

    def exit(self, viewer: Viewer) -> None:
        """Remove a viewer from its room; close the room after its last viewer."""
        room = viewer.room
        if room is None:
            return
        room.viewers.discard(viewer)
        farewell = self.presence.remove(viewer.id, room.id)
        if farewell is not None:
            for other in room.viewers:
                other.outbox.presence[viewer.id] = farewell
                other.outbox.wake.set()
        if not room.viewers and self.rooms.get(room.id) is room:
            del self.rooms[room.id]
            self.shelf.forget(room.stock.key)

    def send_out(self, viewer: Viewer, error: PointbrushError) -> None:
        """Close a viewer's sequence with an error message; keep its socket."""
        room = viewer.room
        if room is None:
            viewer.refuse(error)
            return
        if isinstance(error, NotFoundError):
            error = NotFoundError(f"{room.recording.manifest.name!r} was deleted")
        self.exit(viewer)
        viewer.room = None
        viewer.outbox.restart()
        viewer.refuse(error, closed=room.id)

    # ── events ───────────────────────────────────────────────────────────────────────────

    async def _dispatch_all(self) -> None:
        while True:
            event = await self._events.get()
            try:
                await self._dispatch(event)
            except Exception:
                # The failure of one event must not stop later events.
                logger.exception("could not tell viewers about %s", type(event).__name__)

    async def _dispatch(self, event: Event) -> None:
        if isinstance(event, Job):
            await self._broadcast_job(event)
            return
        if isinstance(event, Compiling):
            message = compiling(event.step, event.progress)
            for viewer in self.viewers:
                viewer.outbox.reply(message)
            return
        if isinstance(event, SequencesChanged):
            await self._sequence_changed(event.sequence)
            return
        room = self.rooms.get(event.sequence)
        if room is not None:
            await self._dispatch_in(room, event)

    async def _dispatch_in(
        self, room: Room, event: ClassesRenamed | Commit | Prepared | Provisional | Retracted
    ) -> None:
        if isinstance(event, Commit):
            await room.on_commit(event)
        elif isinstance(event, Prepared):
            message = encode(messages.Prepared(sequence=event.sequence, frame=event.frame))
            for viewer in room.viewers:
                viewer.outbox.reply(message)
        elif isinstance(event, Provisional):
            room.provisional(event)
        elif isinstance(event, ClassesRenamed):
            room.on_classes_renamed()
        elif isinstance(event, Retracted):
            room.on_retracted(event.frames)

    async def _broadcast_job(self, job: Job) -> None:
        """Send a job's state to all viewers; retry while the database is unavailable."""
        self._unsent_jobs.pop(job.id, None)
        try:
            await self.send_job(job, self.viewers)
        except UnavailableError:
            # The database holds the job's permissions, and viewers need its last state.
            self._unsent_jobs[job.id] = job
            asyncio.get_running_loop().call_later(RESEND_SECONDS, self._resend_job, job)

    def _resend_job(self, job: Job) -> None:
        if self._unsent_jobs.get(job.id) is job:  # no newer state has arrived
            self._events.put_nowait(job)

    async def send_job(self, job: Job, viewers: Iterable[Viewer]) -> None:
        """Queue a job's state for the viewers that may see it; a newer state replaces it."""
        recipients = list(viewers)
        if not recipients:
            return
        permitted = await self.read(
            lambda: [viewer for viewer in recipients if viewer.may_see(job)]
        )
        message = encode(
            messages.Job(
                id=job.id,
                kind=job.kind,
                sequence=job.sequence,
                state=job.state,
                progress=job.progress,
                message=job.message,
                error=job.error,
                edit=job.edit,
                owner=job.owner or "",
            )
        )
        for viewer in permitted:
            viewer.outbox.jobs[job.id] = message
            viewer.outbox.wake.set()

    async def _sequence_changed(self, sequence: str) -> None:
        # Include viewers in the room of an earlier import.
        for viewer in list(self.viewers):
            if viewer.room is not None and viewer.room.id == sequence:
                await viewer.reopen()

    async def _relay_presence(self) -> None:
        while True:
            await asyncio.sleep(self.presence.pause(len(self.viewers), PRESENCE_HZ))
            for sequence, changed in self.presence.take_changes().items():
                room = self.rooms.get(sequence)
                for viewer in room.viewers if room else ():
                    others = {who: data for who, data in changed.items() if who != viewer.id}
                    if others:
                        viewer.outbox.presence.update(others)
                        viewer.outbox.wake.set()
