"""The commands that label: tracking, boxes, labels by example."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush.commands.answers import Answer, confirmed
from pointbrush.commands.arguments import (
    ANY_SEQUENCE,
    FRAMES,
    SEQUENCE,
    SOME_LABELS,
    argument,
    flags_of,
    listed,
    required,
    share,
    switch,
    verb,
    whole,
)
from pointbrush.commands.places import Place, finished
from pointbrush.errors import BadInputError
from pointbrush.names import composed
from pointbrush.settings.definitions import values_of
from pointbrush.values.boxes import BoxFit
from pointbrush.values.runs import TrackingOptions

if TYPE_CHECKING:
    from pointbrush.client import Classifier, Label
    from pointbrush.values.people import FoundPerson

FRAME = whole("a frame number from 0", 0)


@verb(
    SEQUENCE,
    argument("--from", "a labelled frame", dest="start", type=FRAME, required=True, metavar="I"),
    argument(
        "--to", "the last frame; a frame before I tracks backward", dest="stop", type=FRAME,
        required=True, metavar="J",
    ),
    argument("--labels", f"{SOME_LABELS} (default: all labels in frame I)"),
    *flags_of(TrackingOptions),
)  # fmt: skip
def track(given: argparse.Namespace, place: Place) -> Answer:
    """Track labels through the following frames."""
    recording = place[given.sequence]
    labels = _labels_named(given.labels, recording.labels)
    job = recording.start_tracking(
        labels, given.start, given.stop, **values_of(TrackingOptions, given)
    )
    result = finished(place, job)
    line = f"tracked {result['frames']} frames, {result['changed']:,} points labelled"
    return Answer(result, [line])


@verb(
    SEQUENCE,
    argument("--labels", f"{SOME_LABELS} (default: all)"),
    *flags_of(BoxFit, "category", "frames", "redraw"),
)
def fit_boxes(given: argparse.Namespace, place: Place) -> Answer:
    """Fit a box to the points of each label, over all frames."""
    recording = place[given.sequence]
    labels = _labels_named(given.labels, recording.labels)
    job = recording.start_fit_boxes(
        labels, category=given.category, frames=given.frames, redraw=given.redraw
    )
    result = finished(place, job)
    count = len(result["fitted"])
    lines = ["fitted 1 box" if count == 1 else f"fitted {count} boxes"]
    lines += [f"label {label}: {why}" for label, why in result["skipped"].items()]
    return Answer(result, lines)


@verb(SEQUENCE, FRAMES, switch("--apply", "label them, as one edit (default: only count them)"))
def find_people(given: argparse.Namespace, place: Place) -> Answer:
    """Find people in colour pictures of a depth camera."""
    from pointbrush.work.exporting import parse_frames  # slow to import

    recording = place[given.sequence]
    frames = parse_frames(given.frames, len(recording.frames))
    if given.apply:
        result = finished(place, recording.start_find_people(frames))
        return Answer(result, [result["message"]])
    found = recording.find_people(frames)
    return Answer(found, [_person_line(each) for each in found.people] or ["no people found"])


def _person_line(person: FoundPerson) -> str:
    points = sum(each.points for each in person.frames)
    frames = "1 frame" if len(person.frames) == 1 else f"{len(person.frames)} frames"
    return f"{person.name}\t{frames}\t{points:,} points"


def _labels_named(
    text: str | None, palette: Callable[[], Iterable[Label]]
) -> tuple[int, ...] | None:
    """Return the ids of labels by their names or ids, which commas separate; None for no text.

    ``palette`` returns the labels to choose from.  Raises BadInputError.
    """
    if not text:
        return None
    known = list(palette())
    ids = {str(label.id): label.id for label in known} | {label.name: label.id for label in known}
    wanted = composed(text).split(",")
    for part in wanted:
        if part not in ids:
            raise BadInputError(f"--labels: expected names or ids of the palette, got {part!r}")
    return tuple(ids[part] for part in wanted)


@verb(
    argument(
        "sequence", f"{ANY_SEQUENCE}; the examples are painted in it", nargs="?", metavar="SEQ"
    ),
    argument("--classifier", "an existing classifier", metavar="ID"),
    argument("--name", "name of a new classifier (default: the recording's)"),
    argument("--classes", "names of classes, separated by commas (default: the whole palette)"),
    argument("--model", "plug-in or service of a new classifier", default="", metavar="NAME"),
    switch("--imported", "train a new classifier on imported labels, too"),
    argument(
        "--start-from", "labelled recordings that a new classifier starts from, separated by "
        "commas", default="", metavar="SEQ,…",
    ),
    argument(
        "--apply", "label unlabeled and predicted points of frames I to J - 1, or 'all'",
        metavar="I:J",
    ),
    argument(
        "--above", "minimum confidence of applied labels, 0 to 1 (default: measured)", type=share
    ),
    argument("--save", "write the classifier to a file", type=Path, metavar="FILE"),
    argument("--load", "read a file that --save wrote", type=Path, metavar="FILE"),
    switch("--delete", "delete the classifier"),
)  # fmt: skip
def example(given: argparse.Namespace, place: Place) -> Answer:
    """Train a classifier on painted points and label other points with it."""
    known = place.classifiers
    if given.load is not None:
        return _described(known.load(given.load, given.name))
    if given.sequence is None and given.classifier is None:
        return _classifiers(known.all())
    if given.delete:
        known.delete(required("--classifier", given.classifier))
        return confirmed(f"deleted {given.classifier}", classifier=given.classifier)
    taught = _taught(place, given)
    if given.save is not None:
        known.save(taught.id, given.save)
    if given.apply is None:
        return _described(taught)
    recording = place[required("SEQ", given.sequence)]
    frames = "" if given.apply == "all" else given.apply
    result = finished(place, recording.by_example.start(taught.id, frames, given.above))
    done = f"labelled {result['changed']:,} points in {result.get('frames', 0)} frames"
    return Answer({"classifier": taught, "applied": result}, [_line(taught), done])


def _taught(place: Place, given: argparse.Namespace) -> Classifier:
    """Train the given classifier, or a new one."""
    names = [] if given.sequence is None else [place[given.sequence].id]
    if given.classifier is not None:
        return place.classifiers.teach(given.classifier, names)
    classes = None if given.classes is None else listed(given.classes)
    return place.classifiers.create(
        given.name or given.sequence, names, classes, given.model, given.imported,
        listed(given.start_from),
    )  # fmt: skip


def _classifiers(found: Iterable[Classifier]) -> Answer:
    """List classifiers with their examples, recordings and scores."""
    known = list(found)
    if not known:
        return Answer(known, ["no classifiers; `pointbrush example SEQ` trains one"])
    return Answer(known, [_line(each) for each in known], head="ID\tEXAMPLES\tTAUGHT BY\tSCORE")


def _described(found: Classifier) -> Answer:
    """Describe a classifier with its examples, recordings and score."""
    return Answer(found, [_line(found)])


def _line(found: Classifier) -> str:
    examples = ", ".join(f"{name} {count}" for name, count in found.examples.items())
    score = "" if found.score is None else f"\tscore {found.score:.2f}"
    return f"{found.id}\t{examples}\tby {', '.join(found.taught_by) or 'no recording'}{score}"
