"""The note that loops were compiled by Numba, once on a machine.

A note beside what was compiled tells for which versions; who changes a loop compiles it anew when
it is first run.
"""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path

import pointbrush
from pointbrush.sequences.files import replace_file

PACKAGE = Path(pointbrush.__file__).parent
NOTE = "pointbrush-loops.txt"


def are_compiled() -> bool:
    """Whether all loops were compiled; True as well where nobody can know."""
    note = _note()
    try:
        return note is None or note.read_text(encoding="utf-8") == _stamp()
    except (OSError, ValueError):
        return False


def note_compiled() -> None:
    """Note that all loops were compiled."""
    if (note := _note()) is not None:
        note.parent.mkdir(exist_ok=True)
        replace_file(note, _stamp().encode())


def _note() -> Path | None:
    """Return the path of the note; None where compiled loops are kept in no place known here."""
    if folder := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(folder) / NOTE
    return PACKAGE / "__pycache__" / NOTE if os.access(PACKAGE, os.W_OK) else None


def _stamp() -> str:
    return f"{pointbrush.__version__} {version('numba')} {sys.version}"
