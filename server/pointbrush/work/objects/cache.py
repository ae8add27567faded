"""Prepared frames on disk, beside the recordings, bounded in bytes."""

from __future__ import annotations

import contextlib
import hashlib
import os
import uuid
from collections.abc import Callable
from pathlib import Path


class StateFiles:
    """Files under ``folder``: one a recording's import, selector and frame.

    They can be made again, so that any of them may be missing; a folder that cannot be written
    keeps nothing.
    """

    def __init__(self, folder: Path, most_bytes: int) -> None:
        self._folder, self._most = folder, most_bytes

    def path(self, identity: str, selector: str, version: str, frame: int) -> Path:
        """Return where a state is, or would be."""
        told = hashlib.blake2b(f"{selector} {version}".encode(), digest_size=6).hexdigest()
        return self._folder / identity / told / f"{frame:06d}.npz"

    def write(self, path: Path, save: Callable[[Path], None]) -> bool:
        """Write a state whole or not at all; False when the disk did not take it."""
        partial = path.with_name(f".{path.name}-{uuid.uuid4().hex}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            save(partial)
            partial.replace(path)
        except OSError:
            return False
        finally:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
        return True

    def used(self, path: Path) -> None:
        """Note that a file was read: those that were not for longest go first."""
        with contextlib.suppress(OSError):
            os.utime(path)

    def prune(self) -> None:
        """Remove what was not used for longest until the rest fits."""
        found = []
        for path in self._folder.glob("*/*/*.npz"):
            with contextlib.suppress(OSError):
                told = path.stat()
                found.append((told.st_mtime, told.st_size, path))
        total = sum(size for _, size, _ in found)
        for _, size, path in sorted(found):
            if total <= self._most:
                break
            with contextlib.suppress(OSError):
                path.unlink()
            total -= size
