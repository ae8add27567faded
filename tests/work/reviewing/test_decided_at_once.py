"""What a reviewer accepts stays accepted, however many annotators write at the same moment."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from threading import Barrier, Event

from pointbrush.errors import ForbiddenError
from pointbrush.teamwork.reviews import Review
from pointbrush.workspace import Workspace
from tests.serving import add_sequence, settings_in

ANNOTATORS = 4
FRAMES = 8


def test_no_annotator_takes_back_what_was_accepted_meanwhile(tmp_path: Path) -> None:
    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=FRAMES, points=50)
    with closing(Workspace(settings)) as workspace:
        for frame in range(FRAMES):
            ready, done = Barrier(ANNOTATORS + 1), Event()

            def annotate(
                name: str, frame: int = frame, ready: Barrier = ready, done: Event = done
            ) -> None:
                review = Review(frame, frame, state="review")
                ready.wait()
                try:
                    while not done.is_set():
                        workspace.reviewing.put("wall", name, review, decides=False)
                except ForbiddenError:
                    return

            with ThreadPoolExecutor(ANNOTATORS) as pool:
                people = [pool.submit(annotate, f"ann {k}") for k in range(ANNOTATORS)]
                ready.wait()
                workspace.reviewing.put("wall", "ria", Review(frame, frame, state="accepted"))
                done.set()
            for person in people:
                person.result()
            assert workspace.reviewing.frame("wall", frame).state == "accepted"
