"""Users' own models that score classes in place of the trees: plug-ins, and services over HTTP.

A package adds one with an entry point of the group ``pointbrush.classifiers``: a class or function
that returns a ``Model`` when it is called without arguments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.classify.features import Described, ExampleFrame
from pointbrush.classify.grid import means
from pointbrush.classify.options import MOST_CLASSES, NAME_LENGTH
from pointbrush.errors import UnavailableError
from pointbrush.exchange.model_names import ModelNames
from pointbrush.exchange.npz_service import TIMEOUT, NpzService

Features = NDArray[np.float32]
ANSWER_BYTES = 512 * 2**20
"""Most bytes of the answer of a service."""
BUILT_IN = ""
"""Name of the trees among the models."""
POINTS, FEATURES = "points", "features"


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A frame to be scored: its ``points``, z up, and its cells' ``features`` (C, F).

    ``of_point`` (N,) the cell of each point; ``classes`` names (K,) of the columns of scores;
    ``state`` as ``learn`` returned it, empty where nothing taught.
    """

    classes: tuple[str, ...]
    state: bytes
    points: ExampleFrame
    features: Features
    of_point: NDArray[np.int32]


class Model(Protocol):
    """Scores the classes of points or cells; called from several threads and processes."""

    takes: str
    """``points``: a row of scores is a point; ``features``: it is a cell."""
    classes: tuple[str, ...]
    """Names that it knows, which a new classifier has then; empty: any."""
    learns: bool
    """Whether ``learn`` is called with painted cells."""

    def learn(self, features: Features, classes: NDArray[np.int64], names: Sequence[str]) -> bytes:
        """Learn from painted cells (n, F) and their classes (n,), from 0; return the state."""

    def scores(self, question: Question) -> NDArray[np.float32]:
        """Return scores (N, K) or (C, K) from 0; the share of each in its row counts."""


class HttpModel:
    """A ``Model`` on another machine: version 1 of the calls, each a POST of .npz, .npz back.

    ``{address}/v1/about``   ``version``.  Answer: ``takes`` text, ``learns`` bool, ``classes``
                             text (K,).
    ``{address}/v1/learn``   ``features`` float32 (n, F), ``classes`` int64 (n,), ``names`` text
                             (K,).  Answer: ``state`` uint8 (any length), opaque to pointbrush.
    ``{address}/v1/scores``  ``names``, ``state``; for points ``xyz`` float32 (N, 3) and where the
                             frame has them ``rgb`` uint8, ``intensity`` float32, ``returns``; or
                             ``features``.  Answer: ``scores`` float32 (rows, K).
    """

    def __init__(self, address: str, name: str) -> None:
        self._role = f"model {name}"
        self._service = NpzService(address, self._role, ANSWER_BYTES)
        about = self._service.call("about", {"version": np.array(1)}, TIMEOUT)
        self.takes, self.learns = str(about.get("takes")), bool(np.all(about.get("learns", False)))
        known: Any = about.get("classes", np.empty(0, str))
        if known.dtype.kind != "U" or known.size > MOST_CLASSES:
            raise UnavailableError(
                f"{self._role}: expected at most {MOST_CLASSES} names of classes, got "
                f"{known.dtype} {known.shape}"
            )
        self.classes = tuple(str(name)[:NAME_LENGTH] for name in known.ravel())

    def learn(self, features: Features, classes: NDArray[np.int64], names: Sequence[str]) -> bytes:
        """Have the service learn; see ``Model``."""
        given: dict[str, NDArray[Any]] = {
            "features": features,
            "classes": classes,
            "names": np.array(names),
        }
        answer = self._service.call("learn", given, TIMEOUT)
        return bytes(self._service.array(answer, "state", np.uint8).tobytes())

    def scores(self, question: Question) -> NDArray[np.float32]:
        """Ask for scores; see ``Model``."""
        given: dict[str, NDArray[Any]] = {
            "names": np.array(question.classes),
            "state": np.frombuffer(question.state, np.uint8),
        }
        if self.takes == FEATURES:
            given["features"] = question.features
        else:
            points = question.points
            given["xyz"] = np.asarray(points.xyz, np.float32)
            for name in ("rgb", "intensity", "returns"):
                column = getattr(points, name)
                if column is not None:
                    given[name] = column
        answer = self._service.call("scores", given, TIMEOUT)
        if "scores" not in answer or answer["scores"].dtype.kind not in "iuf":
            raise UnavailableError(f"{self._role}: expected scores, numbers, in the answer")
        return answer["scores"].astype(np.float32, copy=False)


class Models(ModelNames):
    """Models of classes that the operator allows by name."""

    GROUP: ClassVar[str] = "pointbrush.classifiers"
    OPTION: ClassVar[str] = "models"

    def make(self, name: str) -> Model:
        """Return the model of a name; raises BadInputError (unknown), UnavailableError."""
        return _made(name, self.address(name))


@lru_cache(maxsize=64)
def _made(name: str, address: str | None) -> Model:
    """Make a model once a process: its weights may be large, a service is asked for its name."""
    if address is None:
        model: Model = Models.plug_in(name)
    else:
        model = HttpModel(address, name)
    if model.takes not in (POINTS, FEATURES):
        raise UnavailableError(f"model {name}: expected points or features, got {model.takes!r}")
    return model


def chances_of(
    model: Model,
    classes: tuple[str, ...],
    state: bytes,
    place: Described,
    points: ExampleFrame,
    name: str,
) -> NDArray[np.float32]:
    """Return the chance (C, K) of each class in each cell by a model; points' mean in their cell.

    ``name``: the model's, for errors.  Raises UnavailableError for scores that are none.
    """
    question = Question(classes, state, points, place.features, place.of_point)
    scores = np.asarray(model.scores(question), np.float64)
    cells = len(place.center)
    rows = cells if model.takes == FEATURES else len(place.of_point)
    if scores.shape != (rows, len(classes)):
        raise UnavailableError(
            f"model {name}: expected scores {(rows, len(classes))} of {model.takes}, "
            f"got {scores.shape}"
        )
    if not (np.isfinite(scores).all() and (scores >= 0).all()):
        raise UnavailableError(f"model {name}: expected finite scores from 0")
    if model.takes == POINTS:
        scores = means(place.of_point, np.ascontiguousarray(scores), cells)
    whole = scores.sum(axis=1, keepdims=True)
    share = np.divide(scores, whole, out=np.full_like(scores, 1 / len(classes)), where=whole > 0)
    return np.asarray(share, np.float32)
