"""Headset checks over REST: a recording in no list, and reports that a workspace keeps."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.errors import ForbiddenError, TooLargeError
from pointbrush.teamwork.headset_reports import KEPT
from tests.serving import Served

REPORT: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "golden" / "headset-quest.json").read_text()
)


@pytest.fixture(scope="module")
def lead(served: Served) -> Iterator[Client]:
    token = served.workspace.labels.tokens.add("manager", "the manager")
    with Client(served.url, token) as opened:
        yield opened


@pytest.fixture(scope="module")
def annotator(served: Served) -> Iterator[Client]:
    token = served.workspace.labels.tokens.add("annotator", "the annotator")
    with Client(served.url, token) as opened:
        yield opened


def test_an_annotator_checks_in_a_recording_that_no_list_contains(
    lead: Client, annotator: Client
) -> None:
    project = lead.projects["default"]
    before = project.statistics().recordings
    project.change(roles={"someone": "viewer"})
    sequence = annotator.call("POST", "/headset-checks").json()["sequence"]
    scratch = annotator[sequence]
    assert len(scratch.labels()) == 2
    first = scratch.labels()[0].id
    values = np.full(scratch.manifest.points[1], first, np.uint16)
    scratch.frames[1].annotate(values)
    for one in (lead, annotator):
        listed = one.call("GET", "/sequences?copies=true").json()
        found = one.call("GET", "/sequences?q=check").json()
        assert sequence not in [entry["id"] for entry in listed + found]
    assert project.statistics().recordings == before
    assert sequence not in lead.projects["default"].info.recordings
    # The next check begins without the strokes of this one.
    assert annotator.call("POST", "/headset-checks").json()["sequence"] == sequence
    assert not scratch.frames[1].annotation().any()
    project.change(roles={})


def test_the_newest_reports_are_kept_for_managers(lead: Client, annotator: Client) -> None:
    annotator.headset_reports.add(REPORT)
    (kept,) = lead.headset_reports.all()
    assert kept.account == "the annotator"
    assert json.loads(json.dumps(kept.report.to_json())) == REPORT
    with pytest.raises(ForbiddenError):
        annotator.headset_reports.all()
    with pytest.raises(TooLargeError, match="65,536"):
        annotator.headset_reports.add(REPORT | {"browser": "x" * 70_000})
    newer = [annotator.headset_reports.add(REPORT) for _ in range(KEPT)]
    assert [each.id for each in lead.headset_reports.all()] == newer[::-1]
