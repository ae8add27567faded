"""The review panel in a browser: how a label is found, and judging a range."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from pointbrush import review
from pointbrush.labels import Write
from pointbrush.review import ReviewPanel
from pointbrush.samples import generate
from pointbrush.settings import Settings
from pointbrush.values.runs import TrackingRequest
from pointbrush.workspace import Workspace
from tests.waiting import PATIENCE

FRAMES = 5
PIN = 1


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workspace]:
    """The sample, its first frame painted, a pin tracked to the end."""
    with closing(Workspace(Settings(workspace=tmp_path_factory.mktemp("ws")))) as opened:
        job = opened.imports.begin_sample(frames=FRAMES)
        assert opened.runner.wait(job.id, PATIENCE).state == "done"
        (manifest,) = opened.library.manifests()
        truth = np.asarray(generate("juggling", frames=1).truth[0])
        truth = truth[opened.recording(manifest.id)[0].source_index]
        points = np.flatnonzero(truth == PIN)
        opened.labels.apply(
            manifest.id,
            edit_id=None,
            author="ada",
            kind="paint",
            writes={0: Write(points, label=PIN, provenance=1)},
            summary="painted",
        )
        job = opened.tracking.start(manifest.id, TrackingRequest(start=0, stop=FRAMES - 1), "ada")
        assert opened.runner.wait(job.id, PATIENCE).state == "done"
        yield opened


def opened(workspace: Workspace, **options: object) -> ReviewPanel:
    panel = review.open(workspace, workspace.library.manifests()[0].id, port=0, **options)
    panel.wait_for_explanation()
    panel.go_to(2)
    return panel


def test_the_steps_of_a_label_are_told_and_drawn(workspace: Workspace, browser: Browser) -> None:
    with closing(opened(workspace, explain=PIN)) as panel:
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{panel.port}/")
        expect(page.get_by_text("How pin 1 is found (auto)")).to_be_visible()
        expect(page.get_by_text("predicted poses,")).to_be_visible()
        for name in ("Hypotheses", "Registered surface", "Background", "Claims"):
            expect(page.get_by_text(name, exact=True)).to_be_visible()
        expect(page.get_by_text("inliers", exact=True)).to_be_visible()
        page.close()


def test_iterations_of_icp_are_stepped_through(workspace: Workspace, browser: Browser) -> None:
    with closing(opened(workspace, explain=PIN, method="icp")) as panel:
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{panel.port}/")
        expect(page.get_by_text("iteration 1 of")).to_be_visible()
        page.close()


def test_a_range_is_rejected_and_accepted(workspace: Workspace, browser: Browser) -> None:
    sequence = workspace.library.manifests()[0].id

    def provenance(frame: int) -> set[int]:
        values = workspace.labels.values(sequence, frame)
        return set(values.provenance[values.label == PIN].tolist())

    with closing(opened(workspace)) as panel:
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{panel.port}/")
        page.get_by_role("button", name="Accept").click()
        expect(page.get_by_text("accepted frames 0 to 4")).to_be_visible()
        assert [provenance(frame) for frame in range(FRAMES)] == [{1}] * FRAMES
        workspace.labels.undo(sequence, "review")
        page.get_by_role("button", name="Reject").click()
        expect(page.get_by_text("rejected frames 0 to 4")).to_be_visible()
        # What a person painted stays.
        assert [provenance(frame) for frame in range(FRAMES)] == [{1}] + [set()] * (FRAMES - 1)
        page.close()
