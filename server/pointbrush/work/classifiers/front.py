"""The service of a workspace for classifiers trained on examples."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from pointbrush.classify.models import Models
from pointbrush.jobs.job import Job
from pointbrush.jobs.runner import JobRunner
from pointbrush.labels import LabelStore
from pointbrush.work.classifiers.applying import ApplyRequest, Predictions
from pointbrush.work.classifiers.options import ApplyOptions
from pointbrush.work.classifiers.service import Classifiers
from pointbrush.work.exporting import parse_frames
from pointbrush.work.job_book import JobBook
from pointbrush.work.library import Library


class ClassifierFront(Classifiers):
    """Classifiers of a workspace, and the jobs that apply them."""

    def __init__(
        self, store: LabelStore, library: Library, runner: JobRunner, jobs: JobBook, folder: Path,
        models: Models,
    ) -> None:  # fmt: skip
        """``folder``: of their files."""
        super().__init__(store, folder, library.recording, library.listed_ids, models=models)
        self._jobs = jobs
        self._predictions = Predictions(store, runner, self.current, self.options, models)

    def apply(self, sequence: str, *, author: str, edit: str | None = None, **chosen: Any) -> Job:
        """Label unlabeled points in frames of a recording with a job, as one edit.

        ``chosen``: fields of ``ApplyOptions``.  ``edit``: id of the edit and the job; if ``author``
        has already started a job with this id, it is returned.
        """
        recording, options = self._recording(sequence), ApplyOptions(**chosen)
        self.about(options.classifier)
        frames = tuple(parse_frames(options.frames or None, len(recording)))
        request = ApplyRequest(frames, options)
        begin = partial(self._predictions.start, recording, request, author)
        return self._jobs.begin_once(edit, author, begin)

    def again(self, job: Job) -> dict[str, Any] | None:
        """Restart a job of an ended server; return its result if it was already committed."""
        return self._predictions.again(self._recording(job.sequence or ""), job)
