"""A viewer's questions before it paints: what a click, a fill or the ground tool would take."""

from __future__ import annotations

import asyncio

from pointbrush.errors import PointbrushError
from pointbrush.ranges import runs_of
from pointbrush.streaming import messages
from pointbrush.streaming.encoding import encode
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.viewer import Viewer
from pointbrush.workspace import Answer


class Asker:
    """Answers one viewer's newest question; older ones that wait are dropped."""

    def __init__(self, viewer: Viewer, hub: Hub) -> None:
        self._viewer, self._hub = viewer, hub
        self._newest: messages.Ask | None = None
        self._asked = asyncio.Event()

    def put(self, question: messages.Ask) -> None:
        """Ask; takes the place of a question that waits."""
        self._newest = question
        self._asked.set()

    async def run(self) -> None:
        """Answer until cancelled."""
        while True:
            await self._asked.wait()
            self._asked.clear()
            question, self._newest = self._newest, None
            if question is None:
                continue
            try:
                sequence = self._viewer.require_room().id
                answer = await self._hub.read(self._answer, sequence, question)
            except PointbrushError as error:
                self._viewer.refuse(error, question.id)
            else:
                self._viewer.outbox.reply(encode(answer_message(question, answer)))

    def _answer(self, sequence: str, question: messages.Ask) -> Answer:
        fields = {
            **question.brush.model_dump(),
            "positives": [sample.model_dump() for sample in question.samples],
            "negatives": [sample.model_dump() for sample in question.negatives],
            "previous": question.previous,
        }
        return self._hub.workspace.ask(sequence, question.frame, fields)


def answer_message(question: messages.Ask, answer: Answer) -> messages.Candidates:
    """Candidates in stored order, as the page numbers points."""
    return messages.Candidates(
        id=question.id,
        frame=question.frame,
        first=answer.first,
        ready=answer.ready,
        candidates=[
            messages.Candidate(
                id=level.id,
                level=level.level,
                score=level.score,
                points=len(level.numbers),
                runs=runs_of(level.numbers).astype("<u4").tobytes(),
            )
            for level in answer.candidates
        ],
    )
