"""Messages between the two processes of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from pointbrush.tracking.interface import F64, I64, Frames
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import Lens
from pointbrush.tracking.sensors.view import View


class Task(NamedTuple):
    """A task for an object: ``do(object, view, *given)``."""

    track: Track
    given: tuple[object, ...]


class Answer(NamedTuple):
    """Message: the ``result`` of a task, the ``state`` of an object that it changed,
    ``seconds``."""

    result: object
    state: Mapping[str, object]
    seconds: float


class Know(NamedTuple):
    """Message: keep a ``value`` by its ``name``."""

    name: object
    value: object


class Show(NamedTuple):
    """Message: read frame ``number``; the other fields are those of its ``View``."""

    number: int
    lens: Lens | None
    options: TrackerOptions
    T_world_frame: F64 | None
    about: F64 | None
    steady: bool

    def view(self, frames: Frames) -> View:
        """The frame as the first process sees it."""
        T = self.T_world_frame
        return View(
            self.number, frames(self.number), self.lens, self.options, T, self.about, self.steady
        )


class Learn(NamedTuple):
    """Message: let the background learn the frame that was shown; see ``Background.learn``."""

    labels: dict[int, I64]
    keep: F64


class Work(NamedTuple):
    """Message: ``do`` the ``tasks``, and send an ``Answer`` to each; see ``SecondProcess.ask``."""

    do: Callable[..., object]
    tasks: list[Task]
    changes: bool


class End(NamedTuple):
    """Message: the run has ended."""
