"""Work on several objects at once, in two processes, where the frames can be had in both.

Who does what is decided by how long it took before, and makes no difference to what comes out.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager
from typing import TypeVar, TypeVarTuple, cast

from pointbrush.tracking.interface import F64, Frames
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.parallel.connection import GONE
from pointbrush.tracking.parallel.messages import Answer, Task
from pointbrush.tracking.parallel.second_process import BACKGROUND, SecondProcess
from pointbrush.tracking.scene.depth import Background, ImageBackground
from pointbrush.tracking.sensors.view import View

logger = logging.getLogger(__name__)
Given = TypeVarTuple("Given")
Result = TypeVar("Result")
Do = Callable[[Track, View, *Given], Result]
"""What is done with an object in a frame, given what it needs beside them."""
Give = Callable[[Track], tuple[*Given]]
"""What is given for an object."""
PER_POINT, AT_LEAST = 5e-6, 0.005
"""Seconds that an object takes of which nothing is known: for each of its points, and in all."""
SENDING = 0.01
"""Seconds a frame that this process takes to ask and to take answers."""


class Workers(AbstractContextManager["Workers"]):
    """This process and, given ``frames`` that pickle, a second one.

    What is done, ``do(object, view, *given(object))``, is the function of a module and touches
    nothing that another object's touches; with ``changes`` it changes the object.  ``show`` a frame
    before anything is done.
    """

    def __init__(self, frames: Frames | None = None) -> None:
        self._second = None if frames is None else SecondProcess(frames)
        self._view: View | None = None
        self._seconds: dict[int, dict[str, float]] = {}
        self._learns = False

    def show(self, view: View, background: Background) -> None:
        """Begin with a frame."""
        self._view = view
        if not self._learns and isinstance(background, ImageBackground):
            self._learns = True
            self._tell(lambda second: second.know(BACKGROUND, background))
        self._tell(lambda second: second.show(view))

    def learn(self, view: View, background: Background, keep: F64) -> None:
        """Let the background take in the frame, here and there; see ``Background.learn``."""
        if self._learns:
            self._tell(lambda second: second.learn(view, keep))
        background.learn(view, keep=keep)

    @property
    def learns(self) -> bool:
        """Whether the second process, if there is one, has the background too."""
        return self._learns

    def _tell(self, what: Callable[[SecondProcess], None]) -> None:
        if self._second is not None:
            try:
                what(self._second)
            except GONE:
                self._alone()

    def each(
        self,
        do: Do[*Given, Result],
        tracks: Iterable[Track],
        given: Give[*Given],
        *,
        changes: bool = False,
        here: bool = False,
    ) -> dict[int, Result]:
        """Label → what came out, in the order of the objects; ``here``: of this process alone."""
        some = list(tracks)
        theirs = [] if here else self._ask(do, self._share(some), given, changes=changes)
        mine = [track for track in some if track not in theirs]
        done = {track.label: self._do(do, track, given) for track in mine}
        done |= self._take(do, theirs, given)
        return {track.label: done[track.label] for track in some}

    def begin(
        self,
        do: Do[*Given, Result],
        tracks: Iterable[Track],
        given: Give[*Given],
        *,
        changes: bool = False,
    ) -> Callable[[], dict[int, Result]]:
        """Let the second process do it all, if there is one; what is given back waits for it."""
        some = list(tracks)
        asked = self._ask(do, some, given, changes=changes)
        mine = [track for track in some if track not in asked]
        return lambda: {
            **self._take(do, asked, given),
            **{track.label: self._do(do, track, given) for track in mine},
        }

    def _share(self, tracks: Sequence[Track]) -> list[Track]:
        """The objects that the second process is to work on: the longest first, evenly."""
        if self._second is None or len(tracks) < 2:
            return []
        expected = {track.label: self._expected(track) for track in tracks}
        load, theirs = [SENDING, 0.0], []
        for track in sorted(tracks, key=lambda track: -expected[track.label]):
            other = load[1] < load[0]
            load[other] += expected[track.label]
            if other:
                theirs.append(track)
        return theirs

    def _expected(self, track: Track) -> float:
        """Seconds; of all that is done, so that the same process has an object all the time."""
        known = self._seconds.get(track.label)
        return sum(known.values()) if known else AT_LEAST + PER_POINT * track.size

    def _took(self, do: Callable[..., object], track: Track, seconds: float) -> None:
        self._seconds.setdefault(track.label, {})[do.__name__] = seconds

    def _do(self, do: Do[*Given, Result], track: Track, given: Give[*Given]) -> Result:
        if self._view is None:
            raise RuntimeError("expected a frame to be shown before anything is done")
        start = time.perf_counter()
        result = do(track, self._view, *given(track))
        self._took(do, track, time.perf_counter() - start)
        return result

    def _ask(
        self, do: Do[*Given, object], tracks: list[Track], given: Give[*Given], *, changes: bool
    ) -> list[Track]:
        """Return those of the objects that the second process will answer for."""
        if self._second is None or not tracks:
            return []
        try:
            tasks = [Task(track, given(track)) for track in tracks]
            self._second.ask(do, tasks, changes=changes)
        except GONE:
            self._alone()
            return []
        return tracks

    def _take(
        self, do: Do[*Given, Result], tracks: list[Track], given: Give[*Given]
    ) -> dict[int, Result]:
        """The second process's answers; what it does not answer is done here."""
        done = {}
        for track in tracks:
            answer = self._answer()
            if answer is None:
                done[track.label] = self._do(do, track, given)
                continue
            track.become(answer.state)
            self._took(do, track, answer.seconds)
            done[track.label] = cast(Result, answer.result)
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
        """Let go of the second process."""
        if self._second is not None:
            self._second.close()
