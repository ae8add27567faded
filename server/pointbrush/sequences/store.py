"""Reading an imported sequence: ``Sequence[i]`` is a ``StoredFrame``."""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import NotFoundError
from pointbrush.sequences.check import read_checksums
from pointbrush.sequences.frame_files import CopiedFiles, MappedFiles, open_frame_files
from pointbrush.sequences.manifest import read_manifest
from pointbrush.sequences.other import read_other, read_rows, read_source_header
from pointbrush.sequences.stored_frame import StoredFrame

log = logging.getLogger(__name__)

FRAMES = "frames"
_OPEN_FRAMES = 256


class Sequence:
    """An imported recording: ``len`` and ``[i]``; immutable, safe to share between threads."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.manifest = read_manifest(path)
        self.identity = self.manifest.identity
        self._frames: OrderedDict[int, StoredFrame] = OrderedDict()
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[Sequence], tuple[Path]]:
        """Another process opens it anew."""
        return Sequence, (self.path,)

    def __len__(self) -> int:
        return self.manifest.frames

    def __getitem__(self, index: int) -> StoredFrame:
        if not 0 <= index < len(self):
            raise NotFoundError(f"expected a frame from 0 to {len(self) - 1}, got {index}")
        with self._lock:
            frame = self._frames.get(index)
            if frame is None:
                frame = StoredFrame(self._files(index), self.manifest)
                self._frames[index] = frame
                if len(self._frames) > _OPEN_FRAMES:
                    self._frames.popitem(last=False)
            else:
                self._frames.move_to_end(index)
        return frame

    def other(self, index: int) -> dict[str, NDArray[Any]]:
        """Further fields of a frame's source, (N,) in source order; {} where it had none.

        Raises NotFoundError, DamagedError.
        """
        count = self[index].count
        return self.other_of(index, 0, count)

    def other_of(self, index: int, first: int, stop: int) -> dict[str, NDArray[Any]]:
        """The same of the points ``first`` to before ``stop`` of the source."""
        return read_other(self.path, self._checksums, index, first, stop, self[index].count)

    def source_header(self, index: int) -> bytes | None:
        """The header of a frame's source as its format keeps it, or None."""
        return read_source_header(self.path, index)

    def source_rows(self, index: int) -> NDArray[np.int64] | None:
        """Return each point's row (N,) in the source; None: as the points, or unknown.

        Raises DamagedError.
        """
        return read_rows(self.path, self._checksums, index, self[index].count)

    def _files(self, index: int) -> CopiedFiles | MappedFiles:
        return open_frame_files(self.path / FRAMES, index, self.manifest, self._checksums)

    @cached_property
    def _checksums(self) -> dict[str, str]:
        """By path in the folder of frames, or, elsewhere, of the recording; empty without any."""
        found = read_checksums(self.path)
        if found is None:
            log.info("%s has no checksums: changed bytes go unnoticed", self.path)
            return {}
        prefix = f"{FRAMES}/"
        return {name.removeprefix(prefix): value for name, value in found.items()}

    def __iter__(self) -> Iterator[StoredFrame]:
        return (self[index] for index in range(len(self)))


def open_sequence(path: Path) -> Sequence:
    """Open the sequence in folder ``path``.

    Raises NotFoundError when there is none, BadInputError when its manifest is damaged.
    """
    return Sequence(path)
