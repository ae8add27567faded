"""LAZ points, decompressed by a child process that may die without harm."""

from __future__ import annotations

import base64
import os
import selectors
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.las_header import LasHeader
from pointbrush.formats.options import Limits

CHILD = Path(__file__).with_name("laz_child.py")


def decoded_records(
    path: Path, header: LasHeader, chunk: int, limits: Limits
) -> Iterator[bytearray]:
    """The point records in blocks of ``chunk`` points, the last one smaller.

    Raises BadInputError when the decoder fails, crashes, stalls or ends early.
    """
    arguments = [
        *(sys.executable, "-I", str(CHILD), str(path.absolute())),
        *(str(header.offset), str(header.record), str(header.count)),
        base64.b64encode(header.laszip or b"").decode("ascii"),
        str(limits.native_memory),
    ]
    with (
        tempfile.TemporaryFile() as complaints,
        subprocess.Popen(
            arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=complaints
        ) as child,
    ):
        try:
            left = header.count
            while left > 0:
                wanted = min(chunk, left) * header.record
                block = _receive(child, wanted, limits.native_stall_seconds)
                if len(block) < wanted:
                    child.wait(limits.native_stall_seconds)
                    complaints.seek(0)
                    lines = complaints.read(4096).decode("utf-8", "replace").strip().splitlines()
                    got = header.count - left + len(block) // header.record
                    why = lines[-1][:200] if lines else f"the decoder ended ({child.returncode})"
                    raise BadInputError(
                        f"{path.name}: expected {header.count} compressed points, got {got}: {why}"
                    )
                left -= min(chunk, left)
                yield block
        except subprocess.TimeoutExpired:
            raise BadInputError(f"{path.name}: the decoder of compressed points stalled") from None
        finally:
            child.kill()


def _receive(child: subprocess.Popen[bytes], size: int, stall: float) -> bytearray:
    """Up to ``size`` bytes; fewer at the end.  Grows with what comes, not with what is claimed."""
    assert child.stdout is not None  # noqa: S101
    descriptor = child.stdout.fileno()
    block = bytearray()
    # Not select(): that fails in a process with more than a thousand open files.
    with selectors.DefaultSelector() as selector:
        selector.register(descriptor, selectors.EVENT_READ)
        while len(block) < size:
            if not selector.select(stall):
                raise subprocess.TimeoutExpired(child.args, stall)
            received = os.read(descriptor, min(size - len(block), 1 << 20))
            if not received:
                break
            block += received
    return block
