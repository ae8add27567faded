"""The review of a recording: states and notes, suspicious labels, agreement, reports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import httpx

from pointbrush.client.answers import read, vector
from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.values.team.review import (
    Agreement,
    Checked,
    Decision,
    Finding,
    ReviewOverview,
    ReviewPatch,
    ReviewState,
    Standing,
)


class Review(Part[L]):
    """The review of one recording."""

    def __init__(self, link: L, sequence: str) -> None:
        super().__init__(link)
        self._sequence = sequence

    def _get(self, path: str, **query: Any) -> Steps[httpx.Response]:
        given = {name: value for name, value in query.items() if value is not None}
        place = f"/sequences/{self._sequence}{path}"
        return send(Request("GET", place, {"params": given}, idempotent=True))

    @steps
    def counts(self) -> Steps[dict[ReviewState, int]]:
        """Return the numbers of open, review, accepted and rejected frames."""
        found = read(ReviewOverview, (yield from self._get("/review")).json())
        return dict(found.counts)

    @steps
    def standings(self) -> Steps[list[Standing]]:
        """Return the states of reviewed runs of frames, then of labels as a whole."""
        found = read(ReviewOverview, (yield from self._get("/review")).json())
        return [*found.frames, *found.labels]

    @steps
    def frame(self, frame: int, label: int | None = None) -> Steps[Standing]:
        """Return the review state of a frame, or of a label in it."""
        answer = yield from self._get(f"/frames/{frame}/review", label=label)
        return read(Standing, answer.json())

    @steps
    def put(
        self,
        first: int | None = None,
        last: int | None = None,
        *,
        label: int | None = None,
        state: ReviewState | None = None,
        note: str | None = None,
        place: Sequence[float] | None = None,
        assignee: str | None = None,
    ) -> Steps[None]:
        """Change the review of frames ``first`` to ``last`` (default: ``first``) or of a label.

        Raises ForbiddenError for an insufficient role, NotFoundError, BadInputError.
        """
        end = first if last is None else last
        body = ReviewPatch(state, note, vector(place), assignee, label, first, end).given()
        path = f"/sequences/{self._sequence}/review"
        yield from send(Request("PUT", path, {"json": body}, idempotent=True))

    @steps
    def history(self, limit: int = 100) -> Steps[list[Decision]]:
        """Return the review decisions with their authors, newest first."""
        answer = yield from self._get("/review/history", limit=limit)
        return [read(Decision, entry) for entry in answer.json()]

    @steps
    def check(self, frames: str | None = None) -> Steps[Checked]:
        """Return the findings in frames ``I:J``, and the skipped checks."""
        return read(Checked, (yield from self._get("/checks", frames=frames)).json())

    @steps
    def checks(self, frames: str | None = None) -> Steps[list[Finding]]:
        """Return the findings in frames ``I:J`` (None: all)."""
        answer = yield from self._get("/checks", frames=frames)
        return list(read(Checked, answer.json()).findings)

    @steps
    def agreement(
        self, other: str, by: str = "name", frames: str | None = None, *, boxes: bool = False
    ) -> Steps[Agreement]:
        """Return the agreement with another recording: IoU by label, differing points by frame.

        ``by``: match labels by "name" or "category".  ``frames``: I:J.  ``boxes``: compare boxes
        as well.
        """
        query = {"with": other, "by": by, "frames": frames, "boxes": "true" if boxes else None}
        return read(Agreement, (yield from self._get("/agreement", **query)).json())

    @steps
    def difference(self, other: str, frame: int, by: str = "name") -> Steps[bytes]:
        """Return a PNG of a frame from above with the differing points."""
        query = {"with": other, "by": by}
        return (yield from self._get(f"/frames/{frame}/agreement", **query)).content

    @steps
    def report(self, out: AnyPath, table: str = "frames") -> Steps[Path]:
        """Write the report to a .html or .csv file, and return its path.

        ``table`` of a .csv: "frames", "labels" or "people".
        """
        target = Path(out)
        csv = target.suffix.lower() == ".csv"
        query = {"format": "csv", "table": table} if csv else {"format": "html"}
        target.write_bytes((yield from self._get("/report", **query)).content)
        return target
