"""The part of a workspace that fits boxes to labels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from pointbrush.jobs.job import Job
from pointbrush.jobs.runner import JobRunner
from pointbrush.labels import LabelStore
from pointbrush.work.boxes.fitting_job import FitRequest, Fits
from pointbrush.work.exporting import parse_frames
from pointbrush.work.job_book import JobBook
from pointbrush.work.library import Library


class Fitting:
    """Fits of boxes, as jobs of a workspace."""

    def __init__(
        self, store: LabelStore, library: Library, runner: JobRunner, jobs: JobBook, database: str
    ) -> None:
        self._recording, self._jobs = library.recording, jobs
        self._fits = Fits(store, runner, database)

    def fit(
        self,
        sequence: str,
        *,
        author: str,
        labels: Sequence[int] | None = None,
        category: str | None = None,
        frames: str | None = None,
        redraw: bool = False,
        edit: str | None = None,
    ) -> Job:
        """Fit boxes to labels in a job; it is one edit.

        ``frames``: "I:J", by default all.  ``edit``: id of the edit and the job; if ``author`` has
        already started a job with this id, it is returned.
        """
        recording = self._recording(sequence)
        request = FitRequest(
            tuple(parse_frames(frames, len(recording))),
            None if labels is None else tuple(labels), category, redraw,
        )  # fmt: skip
        begin = partial(self._fits.start, recording, request, author)
        return self._jobs.begin_once(edit, author, begin)

    def again(self, job: Job) -> dict[str, Any] | None:
        """Restart a job of an ended server; return its result if it was already committed."""
        return self._fits.again(self._recording(job.sequence or ""), job)
