"""Events of a recording as they happen."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TypeAlias

from pointbrush.client.answers import read
from pointbrush.client.steps import AsyncLink, L, Part, Request, Steps, SyncLink, send, steps
from pointbrush.values.edits import PastEdit
from pointbrush.values.jobs import Job
from pointbrush.values.tracking import Events

WAIT_SECONDS = 25.0
"""Seconds for which the server holds a call without events."""


@dataclass(frozen=True, slots=True)
class Doubt:
    """A frame with a doubtful track of a label: lost, occluded, or of low confidence."""

    label: int
    frame: int
    confidence: float
    state: str


Happening: TypeAlias = PastEdit | Doubt | Job


class Watch(Part[L]):
    """An endless iterator of edits, doubts and changes of jobs, for ``for`` and ``async for``.

    No event is missed if the connection is lost or the server restarts: the next call continues
    from ``revision``, the revision of the last returned edit.
    """

    def __init__(self, link: L, place: str, after: int | None, patience: float) -> None:
        super().__init__(link, place)
        self.revision = after
        self._patience = patience
        self._jobs_seen: str | None = None
        self._jobs: dict[str, Job] = {}
        self._ahead: deque[Happening] = deque()

    @steps
    def next(self) -> Steps[Happening]:
        """Wait for the next event and return it; raises UnavailableError after ``patience``."""
        while not self._ahead:
            query = {"wait": WAIT_SECONDS, "after": self.revision, "jobs_seen": self._jobs_seen}
            given = {name: value for name, value in query.items() if value is not None}
            request = Request(
                "GET", f"{self._place}/events", {"params": given}, None, True, self._patience
            )
            self._take(read(Events, (yield from send(request)).json()))
        return self._ahead.popleft()

    def _take(self, answer: Events) -> None:
        self._ahead.extend(answer.edits)
        self._ahead.extend(
            Doubt(each.label, each.frame, each.confidence, each.state) for each in answer.doubts
        )
        changed = [job for job in answer.jobs if self._jobs.get(job.id) != job]
        # The first answer has older jobs, which are no events.
        if self._jobs_seen is not None:
            self._ahead.extend(reversed(changed))
        self._jobs |= {job.id: job for job in changed}
        self.revision, self._jobs_seen = answer.revision, answer.jobs_seen

    def __iter__(self: Watch[SyncLink]) -> Watch[SyncLink]:
        return self

    def __next__(self: Watch[SyncLink]) -> Happening:
        return self.next()

    def __aiter__(self) -> Watch[L]:
        return self

    async def __anext__(self: Watch[AsyncLink]) -> Happening:
        return await self.next()
