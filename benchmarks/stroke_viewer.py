"""A light viewer that paints: it knows when each of its strokes was answered, and what came."""

from __future__ import annotations

import asyncio
import time
import uuid
from typing import Any

import msgpack
from light_viewer import LightViewer


class StrokeViewer(LightViewer):
    """Sends strokes; knows what was refused, and up to which revision it has each frame."""

    peek = 320

    def __init__(self, host: str, token: str) -> None:
        super().__init__(host, token)
        self.waiting: dict[str, tuple[float, asyncio.Future[float]]] = {}
        self.refused: list[str] = []
        self.held: dict[int, int] = {}
        """For each frame that it has values of, the newest revision that it was told of."""
        self.changed: dict[int, int] = {}
        """For each frame, the revision of its own last edit that changed something there."""
        self.gaps = 0

    def stroke(
        self, frame: int, brush: dict[str, object], samples: list[dict[str, object]]
    ) -> asyncio.Future[float]:
        """Send a stroke whole; what is returned becomes the seconds until it was answered."""
        edit = str(uuid.uuid4())
        answer: asyncio.Future[float] = asyncio.get_running_loop().create_future()
        self.send(type="stroke_begin", id=edit, frame=frame, brush=brush)
        self.send(type="stroke_samples", id=edit, samples=samples)
        self.waiting[edit] = (time.perf_counter(), answer)
        self.send(type="stroke_end", id=edit)
        return answer

    def undo(self) -> asyncio.Future[float]:
        """Take back its author's last edit, as ``stroke``."""
        edit = str(uuid.uuid4())
        answer: asyncio.Future[float] = asyncio.get_running_loop().create_future()
        self.waiting[edit] = (time.perf_counter(), answer)
        self.send(type="undo", id=edit)
        return answer

    def _forget(self) -> None:
        """Keep all frames, as a page does whose memory is not full."""

    def _seen(self, peek: bytes, length: int) -> None:
        kind = peek[:32]
        if b"\xadstroke_result" in kind:
            self._answered(msgpack.unpackb(peek))
        elif b"\xa5error" in kind:
            self._refused(msgpack.unpackb(peek))
        elif b"\xaaannotation" in kind:
            self._annotated(peek)
        else:
            super()._seen(peek, length)

    def _answered(self, message: dict[str, Any]) -> None:
        if message["final"]:
            start, answer = self.waiting.pop(message["id"])
            if message["changed"]:
                self.changed[message["frame"]] = message["revision"]
            answer.set_result(time.perf_counter() - start)

    def _refused(self, message: dict[str, Any]) -> None:
        self.refused.append(message["detail"])
        if message["about"] in self.waiting:
            self.waiting.pop(message["about"])[1].cancel()

    def _annotated(self, peek: bytes) -> None:
        unpacker = msgpack.Unpacker(max_buffer_size=self.peek)
        unpacker.feed(peek)
        unpacker.read_map_header()
        # type, sequence, frame, revision and base come first.
        head = {unpacker.unpack(): unpacker.unpack() for _ in range(5)}
        frame, base = head["frame"], head["base"]
        if base is not None and self.held.get(frame, -1) < base:
            self.gaps += 1
        self.held[frame] = head["revision"]
