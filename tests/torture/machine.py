"""Disks that fill up, may not be written or are slow, clocks that jump, limits of a process."""

from __future__ import annotations

import resource
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

SOURCE = Path(__file__).with_name("preloaded.c")


@contextmanager
def mounted(folder: Path, size: int) -> Iterator[Path]:
    """A file system of ``size`` bytes in memory at a new folder, or skip."""
    folder.mkdir()
    _mount("-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder))
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def _mount(*arguments: str) -> None:
    command = ["mount", *arguments]
    if shutil.which("mount") is None or subprocess.run(command, capture_output=True).returncode:
        pytest.skip("this user may not mount a file system")


def preloaded(folder: Path) -> str:
    """Build the library of ``preloaded.c``; returns its path for LD_PRELOAD, or skips."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler is installed (no cc)")
    library = folder / "preloaded.so"
    command = [compiler, "-shared", "-fPIC", "-O1", "-o", str(library), str(SOURCE), "-ldl"]
    subprocess.run(command, check=True)
    return str(library)


@contextmanager
def limited(process: int, kind: int, soft: int) -> Iterator[None]:
    """The soft limit of a running process, one of ``resource.RLIMIT_…``, until the context ends."""
    before = resource.prlimit(process, kind)
    resource.prlimit(process, kind, (soft, before[1]))
    try:
        yield
    finally:
        resource.prlimit(process, kind, before)


def descriptors(process: int) -> int:
    """Return how many files a process has open."""
    return len(list(Path(f"/proc/{process}/fd").iterdir()))


def address_space(process: int) -> int:
    """Return the bytes of addresses that a process has in use."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[0]) * resource.getpagesize()


def resident(process: int) -> int:
    """Return the bytes of memory that a process has."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * resource.getpagesize()


def peak_memory(process: int) -> int:
    """Return the most bytes of memory that a process had at a time."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM:"))


class Ballast:
    """A file that takes all the room there is on a disk."""

    def __init__(self, disk: Path) -> None:
        self.path = disk / "ballast"

    def fill(self) -> None:
        """Write until there is no more room."""
        with self.path.open("ab", buffering=0) as file:
            try:
                while file.write(bytes(4096)):
                    pass
            except OSError:
                return

    def drop(self) -> None:
        """Make room again."""
        self.path.unlink(missing_ok=True)
