"""A viser page on one sequence: step through frames, jump from doubt to doubt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser

from pointbrush.labels import Commit
from pointbrush.review.colors import blend, lookup
from pointbrush.workspace import Event, Workspace

DOUBTFUL = 0.5
"""Confidence under which a tracked frame should be looked at."""
POINT_SIZE = 0.006


def doubtful_frames(tracks: Sequence[Mapping[str, Any]]) -> list[int]:
    """Frames, ascending, in which a label was lost, occluded or tracked with little confidence."""
    return sorted(
        {
            int(track["frame"])
            for track in tracks
            if track["state"] in ("lost", "occluded") or track["confidence"] < DOUBTFUL
        }
    )


class ReviewPanel:
    """The page; ``close`` stops it."""

    def __init__(
        self, workspace: Workspace, sequence: str, host: str = "127.0.0.1", port: int = 8081
    ) -> None:
        """Serve on ``host``:``port``; raises NotFoundError for an unknown sequence."""
        self._workspace, self._sequence = workspace, sequence
        self._recording = workspace.recording(sequence)
        self._server = viser.ViserServer(host=host, port=port, label="pointbrush review")
        self._server.scene.set_up_direction("+y")
        gui = self._server.gui
        last = len(self._recording) - 1
        self._frame = gui.add_slider("Frame", 0, max(last, 1), 1, 0)
        self._share = gui.add_slider("Label colour", 0.0, 1.0, 0.05, 0.7)
        self._doubts = gui.add_markdown("")
        before, after = gui.add_button("Previous doubt"), gui.add_button("Next doubt")
        self._frame.on_update(lambda _: self.show())
        self._share.on_update(lambda _: self.show())
        before.on_click(lambda _: self.jump(-1))
        after.on_click(lambda _: self.jump(1))
        self._unsubscribe = workspace.subscribe(self._on_event)
        self.show()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.get_port())

    @property
    def frame(self) -> int:
        """The frame that is shown."""
        return min(int(self._frame.value), len(self._recording) - 1)

    def show(self) -> None:
        """Send the current frame with its label colours."""
        stored = self._recording[self.frame]
        values = self._workspace.values(self._sequence, self.frame)
        kept = ~values.deleted
        room = self._recording.manifest.T_room_local
        colors = lookup(self._workspace.palette(self._sequence))
        rgb = None if stored.rgb is None else stored.rgb[kept]
        self._server.scene.add_point_cloud(
            "/frame",
            points=(stored.xyz[kept] @ room[:3, :3].T + room[:3, 3]).astype(np.float32),
            colors=blend(rgb, values.label[kept], colors, float(self._share.value)),
            point_size=POINT_SIZE,
        )
        doubts = doubtful_frames(self._workspace.tracks(self._sequence))
        shown = ", ".join(map(str, doubts[:40])) or "none"
        self._doubts.content = f"**Doubtful frames:** {shown}"

    def jump(self, direction: int) -> None:
        """Go to the next (1) or previous (-1) doubtful frame, if there is one."""
        doubts = doubtful_frames(self._workspace.tracks(self._sequence))
        ahead = [frame for frame in doubts if (frame - self.frame) * direction > 0]
        if ahead:
            self.go_to(min(ahead) if direction > 0 else max(ahead))

    def go_to(self, frame: int) -> None:
        """Show ``frame``."""
        slider: Any = self._frame  # viser types the value as read-only, and documents setting it
        slider.value = frame

    def close(self) -> None:
        """Stop serving."""
        self._unsubscribe()
        self._server.stop()

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Commit) and event.sequence == self._sequence:
            self.show()
