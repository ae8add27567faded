"""Frames prepared in advance, one after another, in a separate process, and stored on disk.

Their files are beside the recordings, with a limit of bytes.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import threading
import uuid
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from functools import partial
from pathlib import Path

from pointbrush.errors import PointbrushError
from pointbrush.jobs.worker import local_processes
from pointbrush.selection.selectors import StoredSelector, make_selector
from pointbrush.sequences import Sequence as Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.stored_files import RecordingFiles
from pointbrush.work.objects.choosing import Selectors
from pointbrush.work.objects.frames import object_frame
from pointbrush.work.prepare import ensure_compiled

logger = logging.getLogger(__name__)

Wish = tuple[str, int]
"""A recording's ``placement`` and a frame of it."""
Done = Callable[[Recording, int, object], None]
"""Called with a prepared frame's state, or None if it is on disk."""


class StateFiles:
    """Files in ``folder``, one per import of a recording, selector and frame.

    They are a cache: any file may be missing, and a read-only folder stays empty.
    """

    def __init__(self, folder: Path, most_bytes: int) -> None:
        self.folder, self._most = folder, most_bytes

    def path(self, identity: str, selector: str, version: str, frame: int) -> Path:
        """Return the path of a state, which may not exist."""
        return self.folder / identity / _key(selector, version) / f"{frame:06d}.npz"

    def of(self, selector: str, version: str) -> list[Path]:
        """Return the paths of the states of a selector."""
        return sorted(self.folder.glob(f"*/{_key(selector, version)}/*.npz"))

    def write(self, path: Path, save: Callable[[Path], None]) -> bool:
        """Write a state atomically; return False if it cannot be written."""
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
        """Mark a file as used, for the removal of least recently used files."""
        with contextlib.suppress(OSError):
            os.utime(path)

    def remove(self, path: Path) -> bool:
        """Remove an unreadable state; return False if the folder is read-only."""
        try:
            path.unlink(missing_ok=True)
        except OSError:
            return False
        return True

    def prune(self) -> None:
        """Remove the least recently used states until the rest fits."""
        found = []
        for path in self.folder.glob("*/*/*.npz"):
            with contextlib.suppress(OSError):
                status = path.stat()
                found.append((status.st_mtime, status.st_size, path))
        total = sum(size for _, size, _ in found)
        for _, size, path in sorted(found):
            if total <= self._most:
                break
            with contextlib.suppress(OSError):
                path.unlink()
            total -= size


def _key(selector: str, version: str) -> str:
    return hashlib.blake2b(f"{selector} {version}".encode(), digest_size=6).hexdigest()


class Preparer:
    """Prepares requested frames, newest request first."""

    def __init__(self, selectors: Selectors, files: StateFiles, waiting: int, done: Done) -> None:
        """``waiting``: limit of the queue."""
        self._selectors, self._files = selectors, files
        self._waiting, self._done = waiting, done
        self._wishes: OrderedDict[Wish, tuple[Recording, int]] = OrderedDict()
        """A bounded queue, newest last; as its entries are taken out, it is no ``Cache``."""
        self._working: Wish | None = None
        self._failed: set[Wish] = set()
        self._changed = threading.Condition()
        self._closed = False
        self._pool: ProcessPoolExecutor | None = None
        self._thread: threading.Thread | None = None

    def request(self, recording: Recording, frames: list[int]) -> None:
        """Queue frames for preparation, in their order."""
        with self._changed:
            for frame in reversed(frames):
                wish = (recording.placement, frame)
                if wish in self._failed or wish == self._working:
                    continue
                self._wishes[wish] = (recording, frame)
                self._wishes.move_to_end(wish)
            while len(self._wishes) > self._waiting:
                self._wishes.popitem(last=False)
            if self._thread is None and self._wishes and not self._closed:
                self._thread = threading.Thread(
                    target=self._run, name="pointbrush-objects", daemon=True
                )
                self._thread.start()
            self._changed.notify()

    def close(self) -> None:
        """End the process and the thread."""
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while (wish := self._next()) is not None:
            recording, frame = wish
            try:
                self._prepare(recording, frame)
            except (PointbrushError, BrokenExecutor, OSError, RuntimeError) as error:
                if self._closed:
                    return
                self._pool = None
                self._failed.add((recording.placement, frame))
                logger.warning("frame %d is not prepared for the object tool: %s", frame, error)
            except Exception:
                # A plug-in may raise any error; the tool then uses points around a click.
                self._failed.add((recording.placement, frame))
                logger.exception("frame %d is not prepared for the object tool", frame)
            finally:
                self._working = None

    def _next(self) -> tuple[Recording, int] | None:
        with self._changed:
            while not self._wishes and not self._closed:
                self._changed.wait()
            if self._closed:
                return None
            self._working, wish = self._wishes.popitem()
            return wish

    def _prepare(self, recording: Recording, frame: int) -> None:
        chosen = self._selectors.of(recording.manifest.id)
        name, selector = chosen.name, chosen.selector
        if not isinstance(selector, StoredSelector):
            state = selector.prepare(object_frame(recording[frame], recording.manifest))
            self._done(recording, frame, state)
            return
        target = self._files.path(recording.placement, name, selector.version, frame)
        if not target.exists():
            if self._pool is None:
                self._pool = local_processes(1)
            work = self._pool.submit(prepare_file, recording.files, frame, name, target)
            if not work.result():
                raise OSError("the state was not written: the disk is full or read-only")
            self._files.prune()
        self._done(recording, frame, None)


def prepare_file(files: RecordingFiles, frame: int, name: str, target: Path) -> bool:
    """Prepare a frame and write its state; runs in a worker process."""
    ensure_compiled(["objects"])
    selector, recording = make_selector(name), open_sequence(files)
    assert isinstance(selector, StoredSelector)  # noqa: S101 – others stay in the server
    state = selector.prepare(object_frame(recording[frame], recording.manifest))
    return StateFiles(target.parent, 0).write(target, partial(selector.save, state))
