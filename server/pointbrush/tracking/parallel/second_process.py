"""A second process that works on things of a frame: what is asked of it, and what it answers.

Python's threads hardly help each other over many short NumPy calls.  The second process opens the
frames by itself and gets things, and what else a function is called with, by pickle; what it has
of this frame already is only named.
"""

from __future__ import annotations

import atexit
import os
import pickle
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import IO, Any, NamedTuple

from pointbrush.tracking.interface import F64, Frames
from pointbrush.tracking.objects.free_space import MOST
from pointbrush.tracking.objects.thing import Thing
from pointbrush.tracking.sensor.view import View

PIPE = 1 << 20
"""Bytes that are on their way before the sender waits."""
OURS, BOTH = ("around",), ("near", "moving")
"""Parts of what is given that the second process does without, and that pass only once."""
BACKGROUND = "background"
KEPT = MOST + 1
"""Glimpses of a thing that have a name: the oldest has left by the time that its name is given."""
GONE = (EOFError, OSError, pickle.UnpicklingError)
"""What shows that the other process has ended."""


class Task(NamedTuple):
    """What is to be done with a thing: ``do(thing, view, *given)``."""

    thing: Thing
    given: tuple[Any, ...]


class Answer(NamedTuple):
    """``result`` of a task, what has become of the thing, and how many seconds it took."""

    result: Any
    state: dict[str, Any]
    seconds: float


class _Elsewhere:
    """Stands for what only the other process has."""


class _Names:
    """Objects that both processes have, by name."""

    def __init__(self) -> None:
        self._kept: dict[int, tuple[object, object]] = {}
        self._named: dict[object, object] = {}

    def add(self, name: object, value: object) -> None:
        """Give ``value`` a name, which what had it before loses."""
        if name in self._named:
            self._kept.pop(id(self._named[name]), None)
        self._kept[id(value)] = (name, value)
        self._named[name] = value

    def drop(self, name: object) -> None:
        """Forget a name."""
        self._kept.pop(id(self._named.pop(name, None)), None)

    def name(self, value: object) -> object:
        found = self._kept.get(id(value))
        return None if found is None else found[0]

    def value(self, name: object) -> Any:
        """What has the name; something that stands for it where only the other process has it."""
        if name not in self._named:
            self.add(name, _Elsewhere())
        return self._named[name]


class _Pickler(pickle.Pickler):
    def __init__(self, file: IO[bytes], names: _Names) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._names = names

    def persistent_id(self, value: object) -> object:
        """See ``pickle.Pickler``."""
        return self._names.name(value)


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: IO[bytes], names: _Names) -> None:
        super().__init__(file)
        self._names = names

    def persistent_load(self, name: object) -> object:
        """See ``pickle.Unpickler``."""
        return self._names.value(name)


class _Line:
    """One end of the connection."""

    def __init__(self, incoming: IO[bytes], outgoing: IO[bytes]) -> None:
        self._incoming, self._outgoing = incoming, outgoing
        self.names = _Names()

    def send(self, message: object) -> None:
        _Pickler(self._outgoing, self.names).dump(message)
        self._outgoing.flush()

    def receive(self) -> Any:
        return _Unpickler(self._incoming, self.names).load()


class SecondProcess:
    """The other process.  Where it has ended, all methods raise one of ``GONE``."""

    def __init__(self, frames: Frames) -> None:
        """``frames`` has to pickle."""
        self._process = _waiting() or _begun()
        assert self._process.stdin is not None  # noqa: S101  (piped)
        assert self._process.stdout is not None  # noqa: S101
        self._line = _Line(self._process.stdout, self._process.stdin)
        self._asked: deque[int] = deque()
        self._things: set[int] = set()
        self._glimpses: dict[int, int] = {}
        self._line.send(frames)

    def know(self, name: object, value: object) -> None:
        """Let it have a copy of something; it is only named from then on."""
        self._line.send(("know", (name, value)))
        self._line.names.add(name, value)

    def show(self, view: View) -> None:
        """Let it read a frame, about which it will be asked."""
        self._forget(self._things)
        self._line.names.add("view", view)
        seen = view.number, view.lens, view.T_world_frame, view.about, view.steady
        self._line.send(("show", seen))

    def learn(self, view: View, keep: F64) -> None:
        """Let the background that it knows learn the frame; see ``Background.learn``."""
        self._line.send(("learn", (view.labels, keep)))

    def ask(self, do: Callable[..., Any], tasks: Sequence[Task], *, changes: bool) -> None:
        """Have ``do``, the function of a module, done; each answer is to be taken before the next.

        ``changes``: it changes the things, which else stay as they are until the next frame.
        """
        names = self._line.names
        for thing, given in tasks:
            if names.name(thing.worn) is None:
                self.know(("worn", thing.label), thing.worn)
            for glimpse in thing.glimpses:
                if names.name(glimpse) is None:
                    number = self._glimpses.get(thing.label, 0)
                    self._glimpses[thing.label] = number + 1
                    self.know(("glimpse", thing.label, number % KEPT), glimpse)
            _name_parts(names, thing.label, given, OURS)
        self._line.send(("do", (do, list(tasks), changes)))
        for thing, given in tasks:
            self._asked.append(thing.label)
            _name_parts(names, thing.label, given, BOTH)
            self._things.add(thing.label)
            names.add(("thing", thing.label), thing)
        if changes:
            self._forget({task.thing.label for task in tasks})

    def _forget(self, labels: set[int]) -> None:
        """Things are no more as they were when they were sent."""
        for label in labels:
            self._line.names.drop(("thing", label))
        self._things = self._things - labels

    def answer(self) -> Answer:
        """The next answer, in the order of the tasks."""
        answer: Answer = self._line.receive()
        _name_parts(self._line.names, self._asked.popleft(), [answer.result], OURS + BOTH)
        return answer

    def close(self) -> None:
        """Let the process wait for the next run, with what it has loaded; end it if it is busy."""
        if not (self._asked or _spare):
            with suppress(*GONE):
                self._line.send(("end", None))
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
    for end in (process.stdin, process.stdout):
        with suppress(OSError):
            end.close()  # type: ignore[union-attr]  # piped


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


def _name_parts(names: _Names, label: int, values: Iterable[object], parts: Sequence[str]) -> None:
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
            _serve(_Line(sys.stdin.buffer, outgoing))


def _serve(line: _Line) -> None:
    """Do what comes in a run."""
    frames: Frames = line.receive()
    view: View | None = None
    while True:
        kind, what = line.receive()
        if kind == "end":
            return
        if kind == "know":
            line.names.add(*what)
        elif kind == "learn" and view is not None:
            view.labels, keep = what
            line.names.value(BACKGROUND).learn(view, keep=keep)
        elif kind == "show":
            number, *seen = what
            view = View(number, frames(number), *seen)
            line.names.add("view", view)
            view.prepare()
        else:
            _do(line, view, *what)


def _do(
    line: _Line, view: View | None, do: Callable[..., Any], tasks: list[Task], changes: bool
) -> None:
    for thing, given in tasks:
        line.names.add(("thing", thing.label), thing)
        _name_parts(line.names, thing.label, given, BOTH)
    for thing, given in tasks:
        start = time.perf_counter()
        result = do(thing, view, *given)
        seconds = time.perf_counter() - start
        line.send(Answer(result, vars(thing) if changes else {}, seconds))
        _name_parts(line.names, thing.label, [result], OURS + BOTH)
