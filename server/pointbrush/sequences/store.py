"""Reading an imported sequence: ``Sequence[i]`` is a ``StoredFrame``."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import NotFoundError
from pointbrush.sequences.pictures import CAMERAS, Projection, find_picture, read_projections
from pointbrush.sequences.storage.frame_files import (
    FRAMES,
    CopiedFiles,
    MappedFiles,
)
from pointbrush.sequences.storage.opening import open_frame_files
from pointbrush.sequences.storage.source_fields import (
    FIELDS,
    read_rows,
    read_source_fields,
    read_source_header,
)
from pointbrush.sequences.storage.stored_files import RecordingFiles, files_of
from pointbrush.sequences.stored_frame import StoredFrame

log = logging.getLogger(__name__)


class Sequence:
    """An imported recording: ``len`` and ``[i]``; immutable, safe to share between threads."""

    def __init__(self, place: Path | RecordingFiles) -> None:
        self.files = files_of(place)
        self.manifest = self.files.manifest()
        self.path = self.files.path
        self.identity = self.manifest.identity
        self.placement = self.manifest.placement
        self._frames: Cache[int, StoredFrame] = Cache(self.files.open_frames)

    def __reduce__(self) -> tuple[type[Sequence], tuple[RecordingFiles]]:
        """Pickle the place of the files; another process opens the recording again."""
        return Sequence, (self.files,)

    def __len__(self) -> int:
        return self.manifest.frames

    def __getitem__(self, index: int) -> StoredFrame:
        if not 0 <= index < len(self):
            raise NotFoundError(f"expected a frame from 0 to {len(self) - 1}, got {index}")
        return self._frames.get(index, lambda: StoredFrame(self._files(index), self.manifest))

    def other_of(self, index: int, first: int, stop: int) -> dict[str, NDArray[Any]]:
        """Further fields of the points ``first`` to before ``stop`` of a frame's source.

        They are in source order; {} where the source had none.  Raises NotFoundError, DamagedError.
        """
        with self.files.hold(index, FIELDS):
            return read_source_fields(
                self.path, self._checksums, index, first, stop, self[index].count
            )

    def source_header(self, index: int) -> bytes | None:
        """Return the header of a frame's source, as stored by its format, or None."""
        with self.files.hold(index, FIELDS):
            return read_source_header(self.path, index)

    def source_rows(self, index: int) -> NDArray[np.int64] | None:
        """Return each point's row (N,) in the source; None: as the points, or unknown.

        Raises DamagedError.
        """
        with self.files.hold(index, FIELDS):
            return read_rows(self.path, self._checksums, index, self[index].count)

    @cached_property
    def has_pictures(self) -> bool:
        """True when cameras took pictures of its frames, of all or some; may read a file."""
        return any(name.startswith(f"{CAMERAS}/") for name in self._checksums)

    def projections(self, index: int) -> list[Projection]:
        """Return the pictures that cameras took at a frame, [] where it has none.

        Raises NotFoundError, DamagedError.
        """
        with self.files.hold(self[index].index, CAMERAS):
            return read_projections(self.path, index)

    def picture(self, index: int, camera: str) -> tuple[str, bytes]:
        """Return name and bytes of a camera's picture; raises NotFoundError, DamagedError."""
        with self.files.hold(self[index].index, CAMERAS):
            path = find_picture(self.path, index, camera)
            return path.name, path.read_bytes()

    def _files(self, index: int) -> CopiedFiles | MappedFiles:
        held = self.files.hold(index, FRAMES)
        return open_frame_files(self.path / FRAMES, index, self.manifest, self._checksums, held)

    @cached_property
    def _checksums(self) -> dict[str, str]:
        """By path in the folder of frames, or, elsewhere, of the recording; empty without any."""
        found = self.files.checksums()
        if found is None:
            log.info("%s has no checksums: changed bytes go unnoticed", self.path)
            return {}
        prefix = f"{FRAMES}/"
        return {name.removeprefix(prefix): value for name, value in found.items()}

    def __iter__(self) -> Iterator[StoredFrame]:
        return (self[index] for index in range(len(self)))


def open_sequence(place: Path | RecordingFiles) -> Sequence:
    """Open the sequence at ``place``, a folder or its files elsewhere.

    Raises NotFoundError when there is none, BadInputError when its manifest is damaged.
    """
    return Sequence(place)
