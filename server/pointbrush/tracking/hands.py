"""Work on several things at once, in two processes, where the frames can be had in both.

Who does what is decided by how long it took before, and makes no difference to what comes out.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Any

from pointbrush.tracking.interface import Frames
from pointbrush.tracking.second import GONE, Answer, Second, Task
from pointbrush.tracking.thing import Thing
from pointbrush.tracking.view import View

logger = logging.getLogger(__name__)
Do = Callable[..., Any]
Given = Callable[[Thing], tuple[Any, ...]]
PER_POINT, AT_LEAST = 5e-6, 0.005
"""Seconds that a thing takes of which nothing is known: for each of its points, and in all."""


class Hands(AbstractContextManager["Hands"]):
    """This process and, given ``frames`` that pickle, a second one.

    What is done, ``do(thing, view, *given(thing))``, is the function of a module and touches
    nothing that another thing's touches; with ``changes`` it changes the thing.
    """

    def __init__(self, frames: Frames | None = None) -> None:
        self._second = None if frames is None else Second(frames)
        self._view: View | None = None
        self._seconds: dict[tuple[str, int], float] = {}

    def show(self, view: View) -> None:
        """Begin with a frame."""
        self._view = view
        if self._second is not None:
            try:
                self._second.show(view)
            except GONE:
                self._alone()

    def each(
        self, do: Do, things: Iterable[Thing], given: Given, *, changes: bool = False
    ) -> dict[int, Any]:
        """Label → what came out, in the order of the things."""
        some = list(things)
        theirs = self._ask(do, self._share(do, some), given, changes=changes)
        mine = [thing for thing in some if thing not in theirs]
        done = {thing.label: self._do(do, thing, given) for thing in mine}
        done |= self._take(do, theirs, given)
        return {thing.label: done[thing.label] for thing in some}

    def begin(
        self, do: Do, things: Iterable[Thing], given: Given, *, changes: bool = False
    ) -> Callable[[], dict[int, Any]]:
        """Let the second process do it all, if there is one; what is given back waits for it."""
        some = list(things)
        asked = self._ask(do, some, given, changes=changes)
        mine = [thing for thing in some if thing not in asked]
        return lambda: {
            **self._take(do, asked, given),
            **{thing.label: self._do(do, thing, given) for thing in mine},
        }

    def _share(self, do: Do, things: Sequence[Thing]) -> list[Thing]:
        """The things that the second process is to work on: the longest first, evenly."""
        if self._second is None or len(things) < 2:
            return []
        expected = {thing.label: self._expected(do, thing) for thing in things}
        load, theirs = [0.0, 0.0], []
        for thing in sorted(things, key=lambda thing: -expected[thing.label]):
            other = load[1] < load[0]
            load[other] += expected[thing.label]
            if other:
                theirs.append(thing)
        return theirs

    def _expected(self, do: Do, thing: Thing) -> float:
        known = self._seconds.get((do.__name__, thing.label))
        return AT_LEAST + PER_POINT * thing.size if known is None else known

    def _do(self, do: Do, thing: Thing, given: Given) -> Any:
        start = time.perf_counter()
        result = do(thing, self._view, *given(thing))
        self._seconds[do.__name__, thing.label] = time.perf_counter() - start
        return result

    def _ask(self, do: Do, things: list[Thing], given: Given, *, changes: bool) -> list[Thing]:
        """Those of the things that the second process will answer for."""
        if self._second is None or not things:
            return []
        try:
            tasks = [Task(thing, given(thing)) for thing in things]
            self._second.ask(do, tasks, changes=changes)
        except GONE:
            self._alone()
            return []
        return things

    def _take(self, do: Do, things: list[Thing], given: Given) -> dict[int, Any]:
        """The second process's answers; what it does not answer is done here."""
        done = {}
        for thing in things:
            answer = self._answer()
            if answer is None:
                done[thing.label] = self._do(do, thing, given)
                continue
            vars(thing).update(answer.state)
            self._seconds[do.__name__, thing.label] = answer.seconds
            done[thing.label] = answer.result
        return done

    def _answer(self) -> Answer | None:
        if self._second is not None:
            try:
                return self._second.answer()
            except GONE:
                self._alone()
        return None

    def _alone(self) -> None:
        logger.warning("the second process of a tracking run has ended; going on with one")
        if self._second is not None:
            self._second.close()
            self._second = None

    def __exit__(self, *_: object) -> None:
        """End the second process."""
        if self._second is not None:
            self._second.close()
