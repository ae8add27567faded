"""Image files: all errors that decoders raise for a damaged file become BadInputError."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from PIL import Image, UnidentifiedImageError

from pointbrush.errors import BadInputError, PointbrushError


@contextmanager
def opened(name: str, source: Path | BinaryIO, wanted: str) -> Iterator[Image.Image]:
    """Open an image.  Raises BadInputError: ``name`` is no ``wanted``, also inside the context."""
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(source) as image:
            yield image
    except PointbrushError:
        raise
    except UnidentifiedImageError:  # its message has the path, or the address of an object
        raise BadInputError(f"{name}: expected {wanted}, got another kind of file") from None
    except Exception as error:
        reason = str(error).split("\n")[0][:120] or type(error).__name__
        raise BadInputError(f"{name}: expected {wanted}, {reason}") from None
