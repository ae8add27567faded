"""A second process that works on objects of a frame: both ends of it.

Python's threads hardly help each other over many short NumPy calls.  The second process opens the
frames by itself and gets objects, and what else a function is called with, by pickle; what it has
of this frame already is only named (``connection.py``).
"""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import IO, cast

from pointbrush.tracking.interface import F64, Frames
from pointbrush.tracking.parallel.connection import GONE, Connection, Names
from pointbrush.tracking.parallel.messages import (
    Answer,
    End,
    Know,
    Learn,
    Show,
    Task,
    Work,
)
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View

PIPE = 1 << 20
"""Bytes that are on their way before the sender waits."""
OURS, BOTH = ("around",), ("near", "moving")
"""Parts of what is given that the second process does without, and that pass only once."""
BACKGROUND = "background"
"""Name of the background that both processes keep."""
KEPT = 11
"""Glimpses of an object that have a name: the oldest has left by the time that its name is
given."""


class SecondProcess:
    """The other process.  Where it has ended, all methods raise one of ``GONE``."""

    def __init__(self, frames: Frames) -> None:
        """``frames`` has to pickle."""
        self._process = _waiting() or _begun()
        self._line = Connection(*_pipes(self._process))
        self._asked: deque[int] = deque()
        self._tracks: set[int] = set()
        self._glimpses: dict[int, int] = {}
        self._line.send(frames)

    def know(self, name: object, value: object) -> None:
        """Let it have a copy of something; it is only named from then on."""
        self._line.send(Know(name, value))
        self._line.names.add(name, value)

    def show(self, view: View) -> None:
        """Let it read a frame, about which it will be asked."""
        self._forget(self._tracks)
        self._line.names.add("view", view)
        self._line.send(
            Show(view.number, view.lens, view.options, view.T_world_frame, view.about, view.steady)
        )

    def learn(self, view: View, keep: F64) -> None:
        """Let the background that it knows learn the frame; see ``Background.learn``."""
        self._line.send(Learn(view.labels, keep))

    def ask(self, do: Callable[..., object], tasks: Sequence[Task], *, changes: bool) -> None:
        """Have ``do``, the function of a module, done; each answer is to be taken before the next.

        ``changes``: it changes the objects, which else stay as they are until the next frame.
        """
        names = self._line.names
        for track, given in tasks:
            if names.name(track.appearance) is None:
                self.know(("worn", track.label), track.appearance)
            for carving_view in track.carving_views:
                if names.name(carving_view) is None:
                    number = self._glimpses.get(track.label, 0)
                    self._glimpses[track.label] = number + 1
                    self.know(("glimpse", track.label, number % KEPT), carving_view)
            _name_parts(names, track.label, given, OURS)
        self._line.send(Work(do, list(tasks), changes))
        for track, given in tasks:
            self._asked.append(track.label)
            _name_parts(names, track.label, given, BOTH)
            self._tracks.add(track.label)
            names.add(("thing", track.label), track)
        if changes:
            self._forget({task.track.label for task in tasks})

    def _forget(self, labels: set[int]) -> None:
        """Objects are no more as they were when they were sent."""
        for label in labels:
            self._line.names.drop(("thing", label))
        self._tracks = self._tracks - labels

    def answer(self) -> Answer:
        """The next answer, in the order of the tasks."""
        answer = cast(Answer, self._line.receive())
        _name_parts(self._line.names, self._asked.popleft(), [answer.result], OURS + BOTH)
        return answer

    def close(self) -> None:
        """Let the process wait for the next run, with what it has loaded; end it if it is busy."""
        if not (self._asked or _spare):
            with suppress(*GONE):
                self._line.send(End())
                _spare.append(self._process)
                return
        _end(self._process)


def make_ready() -> None:
    """Begin a process for the next ``SecondProcess``, whose run need not wait for its imports."""
    if not _spare:
        _spare.append(_begun())


_spare: list[subprocess.Popen[bytes]] = []


def _waiting() -> subprocess.Popen[bytes] | None:
    """The process that waits for a run, if there is one and it lives."""
    while _spare:
        process = _spare.pop()
        if process.poll() is None:
            return process
        _end(process)
    return None


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for end in _pipes(process):
        with suppress(OSError):
            end.close()


def _pipes(process: subprocess.Popen[bytes]) -> tuple[IO[bytes], IO[bytes]]:
    """Return what comes from a process that was ``_begun``, and what goes to it."""
    return cast(IO[bytes], process.stdout), cast(IO[bytes], process.stdin)


@atexit.register
def end_waiting() -> None:
    """End the process that waits for a run."""
    while _spare:
        _end(_spare.pop())


def _begun() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        pipesize=PIPE,
    )


def _name_parts(names: Names, label: int, values: Iterable[object], parts: Sequence[str]) -> None:
    """Long arrays do not pass again, or not at all."""
    for value in values:
        for part in parts:
            if hasattr(value, part):
                names.add((part, label), getattr(value, part))


def serve() -> None:
    """Be the second process: of one run after the other, until none comes any more."""
    # What something prints must not come between the answers.
    outgoing = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with suppress(EOFError, BrokenPipeError):
        while True:
            _serve(Connection(sys.stdin.buffer, outgoing))


def _serve(line: Connection) -> None:
    """Do what comes in a run: the first message is its frames."""
    frames = cast(Frames, line.receive())
    view: View | None = None
    while True:
        match line.receive():
            case End():
                return
            case Know(name, value):
                line.names.add(name, value)
            case Show() as show:
                view = show.view(frames)
                line.names.add("view", view)
                view.prepare()
            case Learn(labels, keep) if view is not None:
                view.labels = labels
                cast(Background, line.names.value(BACKGROUND)).learn(view, keep=keep)
            case Work() as work:
                _do(line, view, work)


def _do(line: Connection, view: View | None, work: Work) -> None:
    for track, given in work.tasks:
        line.names.add(("thing", track.label), track)
        _name_parts(line.names, track.label, given, BOTH)
    for track, given in work.tasks:
        start = time.perf_counter()
        result = work.do(track, view, *given)
        seconds = time.perf_counter() - start
        line.send(Answer(result, track.state() if work.changes else {}, seconds))
        _name_parts(line.names, track.label, [result], OURS + BOTH)
