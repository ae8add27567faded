"""Further fields of a source, kept beside a frame so that exports give them back.

One compressed ``.npz`` a frame under ``fields/``, in the source's order of points; a recording
without that folder has none.  Octrees keep none.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import DamagedError
from pointbrush.sequences.files import write_file

FIELDS = "fields"
DAMAGE = (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error)


def write_other(folder: Path, index: int, other: Mapping[str, NDArray[Any]]) -> None:
    """Write the further fields of a frame, in their order."""
    # Numbers for names: a field may be called as nothing that a file can be called.
    arrays = {f"field_{k}": values for k, values in enumerate(other.values())}
    content = io.BytesIO()
    np.savez_compressed(content, names=np.array(list(other)), **arrays)  # type: ignore[arg-type]
    (folder / FIELDS).mkdir(exist_ok=True)
    write_file(folder / FIELDS / f"{index:06d}.npz", content.getvalue())


def read_other(folder: Path, index: int, count: int) -> dict[str, NDArray[Any]]:
    """Return the further fields (count,) of a frame, in the source's order; {} where it has none.

    Raises DamagedError for a file that is not whole.
    """
    path = folder / FIELDS / f"{index:06d}.npz"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            names = [str(name) for name in stored["names"]]
            found = {name: stored[f"field_{k}"] for k, name in enumerate(names)}
    except FileNotFoundError:
        return {}
    except DAMAGE as error:
        raise DamagedError(f"frame {index}: expected its further fields: {error}") from None
    if any(values.shape != (count,) for values in found.values()):
        raise DamagedError(f"frame {index}: expected further fields of {count} points")
    return found
