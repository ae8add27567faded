"""The commands that check and compare labels, and report on them."""

from __future__ import annotations

import argparse
import threading
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush.commands.answers import Answer, confirmed
from pointbrush.commands.arguments import (
    ANY_SEQUENCE,
    FRAMES,
    SEQUENCE,
    argument,
    switch,
    verb,
    whole,
)
from pointbrush.commands.places import Place
from pointbrush.errors import BadInputError

if TYPE_CHECKING:
    from pointbrush.commands.local import LocalClient
    from pointbrush.values.team.review import BoxAgreement, LabelAgreement


@verb(
    SEQUENCE,
    argument(
        "--port", "port to listen on (default: 8081)", default=8081,
        type=whole("a port from 1 to 65535", 1, 65_535),
    ),
    argument(
        "--explain", "show the tracker's steps for this label in each frame", metavar="LABEL",
        type=whole("a label's number", 1, 65_535),
    ),
    argument(
        "--method", "tracking method that is explained (default: auto)", default="auto",
        choices=("auto", "icp", "color-icp"),
    ),
)  # fmt: skip
def review(given: argparse.Namespace, place: LocalClient) -> None:
    """Step through labels and doubtful tracks in viser."""
    from pointbrush.review.panel import ReviewPanel

    sequence, shown = place.id_of(given.sequence), {"explain": given.explain}
    panel = ReviewPanel(place.workspace, sequence, port=given.port, method=given.method, **shown)
    with closing(panel):
        print(f"pointbrush review at http://127.0.0.1:{panel.port}/", flush=True)
        threading.Event().wait()


@verb(
    SEQUENCE,
    FRAMES,
    switch("--fail", "exit with 1 if there are suspicious labels"),
    switch("--all", "list findings that a reviewer has accepted, too"),
)
def check_labels(given: argparse.Namespace, place: Place) -> Answer:
    """List suspicious labels, frame by frame."""
    checked = place[given.sequence].review.check(given.frames)
    wanted = [each for each in checked.findings if given.all or not each.settled]
    lines = []
    for each in wanted:
        frames = "palette" if each.first is None else f"frame {each.first}"
        if each.last != each.first:
            frames = f"frames {each.first} to {each.last}"
        lines.append(f"{frames}: {each.text}")
    lines.append(f"{len(wanted)} suspicious")
    value = {"findings": wanted, "unchecked": list(checked.unchecked)}
    error = f"{len(wanted)} suspicious" if given.fail and wanted else ""
    return Answer(value, lines, [f"not checked: {each}" for each in checked.unchecked], error=error)


@verb(
    argument("sequence", f"{ANY_SEQUENCE}; the truth of --boxes", metavar="SEQ"),
    argument("other", "a recording of the same points", metavar="SEQ2"),
    FRAMES,
    switch("--boxes", "compare boxes by class: AP, precision, recall, HOTA"),
)
def compare(given: argparse.Namespace, place: Place) -> Answer:
    """Compare the labels of two recordings of one scene."""
    recording, other = place[given.sequence], place[given.other].id
    found = recording.review.agreement(other, frames=given.frames, boxes=given.boxes)
    if found.boxes is not None:
        return _boxes_compared(found.boxes)
    return _labels_compared(found.labels, found.miou)


def _labels_compared(labels: Sequence[LabelAgreement], miou: float | None) -> Answer:
    """List the IoU of labels of two recordings."""
    lines = [f"{each.iou:.3f}  {each.name}" for each in labels]
    lines.append(
        "neither recording has labels" if miou is None else f"{miou:.3f}  mean of all labels"
    )
    value = [{"name": each.name, "iou": each.iou} for each in labels]
    return Answer({"labels": value, "miou": miou}, lines, head="IoU    label")


def _boxes_compared(found: BoxAgreement) -> Answer:
    """List the agreement of boxes by class, with a line for each minimum 3D IoU of a match."""
    lines = [
        f"{one.name}: {one.second} boxes for {one.first}, IoU from {at.iou}: "
        f"AP {at.ap:.3f}, precision {at.precision:.3f}, recall {at.recall:.3f}"
        for one in found.classes
        for at in one.scores
    ]
    if not found.classes:
        lines.append("neither recording has boxes")
    elif found.hota is None:
        lines.append("HOTA: not computed; 'pip install trackeval'")
    else:
        lines.append(f"HOTA {found.hota:.3f}")
    return Answer({"classes": list(found.classes), "hota": found.hota}, lines)


@verb(
    SEQUENCE,
    argument("--out", "file to write: .html or .csv", required=True, type=Path),
    argument(
        "--table", "table of a .csv (default: frames)", default="frames",
        choices=("frames", "labels", "people"),
    ),
)  # fmt: skip
def report(given: argparse.Namespace, place: Place) -> Answer:
    """Write a report of progress and of time spent by person."""
    if given.out.suffix.lower() not in (".html", ".csv"):
        raise BadInputError(f"--out: expected a file .html or .csv, got {given.out.name!r}")
    place[given.sequence].review.report(given.out, given.table)
    return confirmed(f"wrote {given.out}", file=str(given.out))
