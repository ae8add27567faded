"""The scratch recording of headset checks: created at its first use, and not listed."""

from __future__ import annotations

import threading

from pointbrush.database.project_tables import FIRST
from pointbrush.names import SCRATCH
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.annotate.copying import Copying
from pointbrush.work.library import Library

FRAMES = 4
"""Number of frames of a Kinect 2, 0.2 million points each: a second of work and 4 MB per frame."""
LABELS = {"First label": "#ff8c42", "Second label": "#3fa7d6"}
"""Labels to switch between: name → colour."""


class Scratch:
    """The scratch recording of one workspace; thread-safe.

    It is marked as a copy of itself, which excludes it from statistics, versions and webhooks.
    """

    def __init__(self, store: WorkspaceStore, library: Library) -> None:
        self._store, self._library = store, library
        self._clearing = Copying(store, library.recording)
        self._lock = threading.Lock()

    def prepare(self) -> str:
        """Return the id of the scratch recording after clearing all its labels.

        Raises ReadOnlyError, UnavailableError, and ConflictError while another server creates it.
        """
        with self._lock:
            if not self._library.has(SCRATCH):
                self._make()
            manifest = self._library.recording(SCRATCH).manifest
            self._store.recordings.register(SCRATCH, manifest.points, manifest.identity)
            self._store.team.copies.mark(SCRATCH, SCRATCH, FIRST, "scratch")
            known = self._store.palette(SCRATCH)
            for name in list(LABELS)[len(known) :]:
                self._store.create_label(SCRATCH, "import", name=name, color=LABELS[name])
            ids = [label.id for label in self._store.palette(SCRATCH)]
            self._clearing.clear(SCRATCH, range(manifest.frames), ids, "import")
        return SCRATCH

    def _make(self) -> None:
        from pointbrush.samples import generate

        self._library.require_writable()
        self._store.recordings.forget(SCRATCH)  # labels of removed files
        guard = self._store.guards.reserve([SCRATCH], self._library.is_free)
        recording = generate("juggling", frames=FRAMES)
        try:
            with self._library.store.target(SCRATCH).building(lambda *_: None) as folder:
                import_frames(
                    recording.frames,
                    folder,
                    RecordingInfo(
                        SCRATCH, "Headset check", recording.fps, source="made for headset checks"
                    ),
                    total=FRAMES,
                )
        finally:
            self._store.guards.end(guard)
