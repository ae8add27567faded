"""A classifier taught by example: its examples, trees and file.

The file is an ``.npz`` of plain arrays; every array is checked before use.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import Described, ExampleFrame, feature_names
from pointbrush.classify.forest import Trees, is_shallow, probabilities
from pointbrush.classify.models import BUILT_IN, Model, chances_of
from pointbrush.classify.options import (
    LARGEST,
    LARGEST_CELL,
    MOST_BYTES,
    MOST_CLASSES,
    MOST_DEPTH,
    MOST_IGNORED,
    MOST_TREES,
    NAME_LENGTH,
    SMALLEST_CELL,
    FeatureOptions,
    ForestOptions,
)
from pointbrush.classify.reliability import DEFAULT_ABOVE, Taught, reliability
from pointbrush.classify.smoothing import Chances, average_over_pieces, smoothed
from pointbrush.errors import BadInputError
from pointbrush.exchange.npz import Arrays, checked, read_npz
from pointbrush.values.classifiers import HeldOut

Floats = NDArray[np.float64]

VERSION = 2
"""Version of the file and of the meaning of features."""
OLDER = (1,)
"""Versions of files with other features."""
MOST_EARLIER = 6_000
"""Examples of earlier work at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Cells of one frame as examples: ``features`` (n, F), ``classes`` (n,), ``place`` (n,).

    ``classes`` count from 0 in the classifier's; examples of one ``place`` lie together.
    ``spread`` (F,) standard deviations of the features in the whole frame.  ``identity``: of the
    import that the frame is of; ``revision``: of the frame's last change when they were taken.
    """

    features: NDArray[np.float32]
    classes: NDArray[np.uint8]
    place: NDArray[np.int64]
    spread: Floats
    identity: str = ""
    revision: int = 0

    def __len__(self) -> int:
        return len(self.classes)


@dataclass(frozen=True, slots=True)
class Ignored:
    """Points that are of no class, or that were ``skipped``: these are predicted, but not asked.

    ``runs`` of their stored numbers, first and length; without runs, the ball round ``centre``,
    local metres.  ``identity``: of the import that the frame is of.
    """

    identity: str
    frame: int
    centre: tuple[float, float, float]
    radius: float
    runs: tuple[tuple[int, int], ...] = ()
    skipped: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Classifier:
    """Classes, their examples, and the trees that predict them.

    ``recordings`` with examples; ``examples`` by recording and frame; ``size`` of a cell, metres,
    0 without examples; ``score``, ``held_out``, ``above``: as in ``Reliability``.
    ``start_from``: recordings of earlier work with labels that it started from.  ``model``: name
    of the model that predicts in place of the trees; ``state``: its learnt state, None before.
    ``imported``: imported labels are examples beside painted ones.
    ``ignored``: places that it neither labels nor asks about, the last answer last.
    """

    name: str
    classes: tuple[str, ...]
    size: float = 0.0
    recordings: tuple[str, ...] = ()
    examples: Mapping[tuple[str, int], Examples] = field(default_factory=dict)
    trees: Trees | None = None
    score: float | None = None
    model: str = BUILT_IN
    state: bytes | None = None
    imported: bool = False
    ignored: tuple[Ignored, ...] = ()
    start_from: tuple[str, ...] = ()
    held_out: tuple[HeldOut, ...] = ()
    above: float = DEFAULT_ABOVE

    @property
    def ready(self) -> bool:
        """Whether it can tell classes apart."""
        return self.trees is not None or self.state is not None

    @property
    def taught_by(self) -> dict[str, int]:
        """Recordings that taught it, and how many examples each gave."""
        found = dict.fromkeys(self.recordings, 0)
        for (recording, _), some in self.examples.items():
            if not self._is_earlier(recording):
                found[recording] = found.get(recording, 0) + len(some)
        return found

    @property
    def counts(self) -> NDArray[np.int64]:
        """Examples (K,) of each class."""
        found = np.zeros(len(self.classes), np.int64)
        for some in self.examples.values():
            found += np.bincount(some.classes, minlength=len(found))
        return found

    @property
    def spread(self) -> Floats:
        """Standard deviations (F,) of the features in the frames that taught it."""
        width = len(feature_names(FeatureOptions()))
        every = [some.spread for some in self.examples.values()]
        return np.mean(every, axis=0) if every else np.ones(width)

    def taught(self, most: int) -> Taught:
        """Return at most ``most`` examples, classes alike; fewer of them are of earlier work."""
        width = len(feature_names(FeatureOptions()))
        every = list(self.examples.values())
        if not every:
            none = np.zeros(0, np.int64)
            return Taught(np.zeros((0, width), np.float32), none, none, none.astype(np.bool_))
        classes = np.concatenate([each.classes for each in every]).astype(np.int64)
        place = np.concatenate([each.place * len(every) + k for k, each in enumerate(every)])
        is_own = [not self._is_earlier(recording) for recording, _ in self.examples]
        own = np.repeat(is_own, [len(each) for each in every])
        mine, earlier = np.flatnonzero(own), np.flatnonzero(~own)
        mine = mine[balanced(classes[mine], most)]
        left = min(most - len(mine), MOST_EARLIER)
        earlier = earlier[balanced(classes[earlier], left)] if left > 0 else earlier[:0]
        kept = np.sort(np.concatenate([mine, earlier]))
        features = np.concatenate([each.features for each in every])[kept]
        return Taught(features, classes[kept], place[kept], own[kept])

    def _is_earlier(self, recording: str) -> bool:
        return recording in self.start_from and recording not in self.recordings

    def called(self, names: Sequence[str]) -> Classifier:
        """Return a copy with other names of the classes.

        Classes with the same name become one; the examples must be learnt again then.
        """
        classes = tuple(dict.fromkeys(names))
        if len(classes) == len(self.classes):
            return replace(self, classes=classes)
        place = np.array([classes.index(name) for name in names], np.uint8)
        examples = {
            key: replace(some, classes=place[some.classes]) for key, some in self.examples.items()
        }
        merged = replace(self, classes=classes, examples=examples)
        return replace(merged, trees=None, state=None, score=None, held_out=())

    def learnt(self, options: ForestOptions, model: Model | None = None) -> Classifier:
        """Return the same with trees, or its ``model``'s state, that know all examples."""
        if model is not None and not model.learns:
            return replace(self, state=b"")
        taught = self.taught(options.most)
        if not len(taught.classes):
            return replace(self, trees=None, state=None, score=None, held_out=())
        if model is not None:
            state = model.learn(taught.features, taught.classes, self.classes)
            return replace(self, state=state)
        return replace(self, trees=taught.learnt(len(self.classes), self.spread, options))

    def scored(
        self, options: ForestOptions, features: NDArray[np.float32], chance: Chances
    ) -> Classifier:
        """Return the same with the reliability of its trees in frames that taught it.

        ``features`` (n, F) and ``chance`` (n, K) of a sample of the frames' points.
        """
        if self.trees is None:
            return self
        found = reliability(self.taught(options.most), self.trees, features, chance)
        return replace(self, **found._asdict())

    def chances(
        self, place: Described, points: Callable[[], ExampleFrame], model: Model | None = None
    ) -> Chances:
        """Return the chance (C, K) of each class in each cell of a frame of ``points``."""
        if self.state is not None and model is not None:
            return chances_of(model, self.classes, self.state, place, points(), self.model)
        if self.trees is None:
            count = len(self.classes)
            return np.full((len(place.center), count), 1 / count, np.float32)
        chance = smoothed(probabilities(self.trees, place.features), place.near)
        return average_over_pieces(chance, place.piece)


def balanced(classes: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """Choose at most ``most`` examples (n,), the same of each class as far as there are."""
    if len(classes) <= most:
        return np.arange(len(classes))
    held = np.bincount(classes)
    share, left = most, sorted(held[held > 0].tolist())
    for k, count in enumerate(left):
        share = most // (len(left) - k)
        if count >= share:
            break
        most -= count
    chosen = []
    for kind in np.flatnonzero(held):
        members = np.flatnonzero(classes == kind)
        take = min(len(members), share)
        chosen.append(members[np.linspace(0, len(members) - 1, take).astype(np.int64)])
    return np.sort(np.concatenate(chosen))


# ── the file ─────────────────────────────────────────────────────────────────────────────────


def to_file(classifier: Classifier) -> bytes:
    """Return the bytes of a classifier's file."""
    header = {
        "version": VERSION,
        "name": classifier.name,
        "classes": classifier.classes,
        "features": feature_names(FeatureOptions()),
        "size": classifier.size,
        "score": classifier.score,
        "held_out": [astuple(each) for each in classifier.held_out],
        "above": classifier.above,
        "start_from": classifier.start_from,
        "model": classifier.model,
        "imported": classifier.imported,
        "recordings": classifier.recordings,
        "examples": [
            [recording, frame, len(some), some.identity, some.revision]
            for (recording, frame), some in classifier.examples.items()
        ],
        "ignored": [astuple(each) for each in classifier.ignored],
    }  # fmt: skip
    arrays: dict[str, NDArray[Any]] = {
        "about": np.frombuffer(json.dumps(header).encode(), np.uint8)
    }
    if every := list(classifier.examples.values()):
        arrays["example_features"] = np.concatenate([each.features for each in every])
        arrays["example_classes"] = np.concatenate([each.classes for each in every])
        arrays["example_places"] = np.concatenate([each.place for each in every])
        arrays["example_spreads"] = np.stack([each.spread for each in every])
    if classifier.trees is not None:
        arrays |= classifier.trees._asdict()
    if classifier.state is not None:
        arrays["state"] = np.frombuffer(classifier.state, np.uint8)
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no mapping
    return out.getvalue()


def from_file(data: bytes, *, stored: bool = False) -> Classifier:
    """Return the classifier of a file.  Raises BadInputError for anything else.

    ``stored``: a file of this workspace.  One of an older version has other features: it is
    returned without examples, so that it learns again from its recordings.
    """
    try:
        arrays = read_npz(data, MOST_BYTES)
        about = json.loads(checked(arrays, "about", np.uint8, (None,)).tobytes())
        return _checked(about, arrays, stored)
    except BadInputError as error:
        raise BadInputError(f"classifier: {error}") from None
    except (ValueError, LookupError, TypeError, RecursionError, OverflowError) as error:
        raise BadInputError(f"classifier: expected a file of one, got {error}"[:300]) from None


def _checked(about: Any, arrays: Arrays, stored: bool) -> Classifier:
    if stored and about["version"] in OLDER:
        nothing = {"examples": (), "score": None, "start_from": (), "held_out": ()}
        about, arrays = about | nothing | {"above": DEFAULT_ABOVE}, {}
    elif about["version"] != VERSION:
        raise BadInputError(f"expected version {VERSION}, got {about['version']}")
    names = feature_names(FeatureOptions())
    if arrays and tuple(about["features"]) != names:
        raise BadInputError("expected the features of this version, got others")
    classes = check_classes(about["classes"])
    size = float(about["size"])
    _require(size == 0 or SMALLEST_CELL <= size <= LARGEST_CELL, "a cell size in metres", size)
    score = _share(about["score"], "score")
    recordings = tuple(check_name(each) for each in about["recordings"])
    examples = _examples(about["examples"], arrays, len(names), len(classes))
    trees = _trees(arrays, len(names), len(classes)) if "roots" in arrays else None
    name = check_name(about["name"])
    state = checked(arrays, "state", np.uint8, (None,)).tobytes() if "state" in arrays else None
    model = about.get("model") and check_name(about["model"])
    return Classifier(
        name, classes, size, recordings, examples, trees, score, model or BUILT_IN, state,
        bool(about.get("imported")), _ignored(about.get("ignored", ())),
        tuple(check_name(each) for each in about["start_from"]),
        _held_out(about["held_out"], len(classes)), _share(about["above"], "above") or 0.0,
    )  # fmt: skip


def _share(value: Any, name: str) -> float | None:
    share = None if value is None else float(value)
    _require(share is None or 0 <= share <= 1, f"{name} from 0 to 1", share)
    return share


def _held_out(rows: Sequence[Any], kinds: int) -> tuple[HeldOut, ...]:
    _require(len(rows) in (0, kinds), "held_out for each class", len(rows))
    return tuple(HeldOut(_share(share, "held_out"), int(places)) for share, places in rows)


def _ignored(rows: Sequence[Any]) -> tuple[Ignored, ...]:
    _require(len(rows) <= MOST_IGNORED, f"at most {MOST_IGNORED} ignored places", len(rows))
    found = []
    for identity, frame, (x, y, z), radius, *more in rows:
        sizes = [float(each) for each in (x, y, z, radius)]
        _require(bool(np.abs(sizes).max() < LARGEST), "ignored places in metres", sizes)
        runs, skipped = more or ((), False)
        found.append(
            Ignored(
                str(identity), int(frame), (sizes[0], sizes[1], sizes[2]), sizes[3],
                tuple((int(start), int(length)) for start, length in runs), bool(skipped),
            )
        )  # fmt: skip
    return tuple(found)


def _examples(
    rows: Sequence[Any], arrays: Arrays, width: int, kinds: int
) -> dict[tuple[str, int], Examples]:
    if not rows:
        return {}
    lengths = [int(count) for _, _, count, _, _ in rows]
    total = sum(lengths)
    _require(min(lengths) >= 0, "numbers of examples", min(lengths))
    features = checked(arrays, "example_features", np.float32, (total, width), -LARGEST, LARGEST)
    classes = checked(arrays, "example_classes", np.uint8, (total,), 0, kinds - 1)
    places = checked(arrays, "example_places", np.int64, (total,))
    spreads = checked(arrays, "example_spreads", np.float64, (len(rows), width), 0, LARGEST)
    ends = np.cumsum(lengths)
    found = {}
    for k, (recording, frame, n, identity, revision) in enumerate(rows):
        part = slice(ends[k] - n, ends[k])
        found[str(recording)[:NAME_LENGTH], int(frame)] = Examples(
            features[part], classes[part], places[part], spreads[k], str(identity), int(revision)
        )
    return found


def _trees(arrays: Arrays, width: int, kinds: int) -> Trees:
    """Check trees: the loops that read them index without checks."""
    feature = checked(arrays, "feature", np.int16, (None,), -1, width - 1)
    chance = checked(arrays, "chance", np.float32, (None, kinds), 0, 1)
    n, leaves = len(feature), len(chance)
    threshold = checked(arrays, "threshold", np.float32, (n,), -LARGEST, LARGEST)
    left = checked(arrays, "left", np.int32, (n,), 0, max(n, leaves) - 1)
    roots = checked(arrays, "roots", np.int32, (None,), 0, n - 1)
    _require(0 < len(roots) <= MOST_TREES, f"1 to {MOST_TREES} trees", len(roots))
    inner = feature >= 0
    # int64: the sum of an int32 link and 1 could overflow.
    links, number = left.astype(np.int64), np.arange(n)
    good = (links[inner] > number[inner]).all() and (links[inner] + 1 < n).all()
    _require(bool(good), "links from each node to two later ones", "others")
    _require(bool((links[~inner] < leaves).all()), "leaves with a row of chances", "others")
    trees = Trees(feature, threshold, left, roots, chance)
    _require(is_shallow(trees, MOST_DEPTH), f"at most {MOST_DEPTH} nodes from root to leaf", "more")
    return trees


def _require(good: bool, expected: str, got: object) -> None:
    if not good:
        raise BadInputError(f"expected {expected}, got {got}")


def check_name(name: Any) -> str:
    """Return a name of 1 to 128 characters; raises BadInputError."""
    if not isinstance(name, str) or not 1 <= len(name) <= NAME_LENGTH or not name.isprintable():
        raise BadInputError(f"name: expected 1 to {NAME_LENGTH} printable characters")
    return name


def check_classes(classes: Any) -> tuple[str, ...]:
    """Return names of 1 to 64 different classes; raises BadInputError."""
    if not isinstance(classes, list | tuple) or not 1 <= len(classes) <= MOST_CLASSES:
        raise BadInputError(f"classes: expected 1 to {MOST_CLASSES} names")
    found = tuple(check_name(each) for each in classes)
    if len(set(found)) < len(found):
        raise BadInputError("classes: expected different names")
    return found
