"""Paths of this machine that a caller over the network may name: those under the import roots."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from pointbrush.errors import NotFoundError
from pointbrush.formats.inside import is_inside, outside


def allowed(given: str, roots: Sequence[Path]) -> list[Path]:
    """Return the paths that ``given`` (a path or a glob) names under the resolved ``roots``.

    Raises ForbiddenError for a path that lies or leads outside, or is hidden: always with the same
    text, so that it tells nothing of what is there; NotFoundError for one that is missing inside.
    """
    path = Path(os.path.normpath(Path.cwd() / given))
    if not is_inside(path, roots):
        raise outside()
    if os.path.lexists(path):
        return [Path(os.path.realpath(path))]
    found: list[Path] = []
    for pattern in _beginnings(path) if glob.has_magic(given) else ():
        # Each part by itself: what lies behind a link that leads out is not looked at.
        found = [Path(match) for match in glob.glob(pattern, recursive=True)]  # noqa: PTH207
        if not all(is_inside(match, roots) for match in found):
            raise outside()
    if not found:
        raise missing()
    return [Path(os.path.realpath(match)) for match in found]


def _beginnings(path: Path) -> Iterator[str]:
    """The pattern part by part, from the first that has a wildcard."""
    for count in range(1, len(path.parts) + 1):
        pattern = str(Path(*path.parts[:count]))
        if glob.has_magic(pattern):
            yield pattern


def missing() -> NotFoundError:
    """The answer to a path that may be read and is not there."""
    return NotFoundError("path: expected a file or folder, there is none of this name")
