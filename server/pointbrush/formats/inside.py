"""Paths under given folders, with links followed: checks, and expansion of a caller's paths."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from pointbrush.errors import ForbiddenError, NotFoundError
from pointbrush.names import stored_as


def is_inside(path: Path, roots: Sequence[Path]) -> bool:
    """Return whether ``path``, with its links followed, is under one of ``roots`` (resolved), and
    no part of it is hidden.

    It need not exist: a link to the outside counts also if its target does not exist.
    """
    real = Path(os.path.realpath(path))
    named = [path.relative_to(root) for root in roots if path.is_relative_to(root)]
    if named and all(_is_hidden(below) for below in named):
        return False
    return any(
        real.is_relative_to(root) and not _is_hidden(real.relative_to(root)) for root in roots
    )


def file_in(folder: Path, name: str) -> Path | None:
    """Return the file in ``folder`` that another file names, or None if it is not there."""
    try:
        path = stored_as(folder / name)
        return path if path.is_file() and path.resolve().is_relative_to(folder.resolve()) else None
    except (OSError, ValueError):  # too long, or with invalid characters
        return None


def require_inside(paths: Sequence[Path], roots: Sequence[Path]) -> None:
    """Raise ForbiddenError unless ``paths`` and the targets of all links below them are inside."""
    for path in paths:
        if not all(is_inside(found, roots) for found in (path, *_links(path))):
            raise outside()


def outside() -> ForbiddenError:
    """Return the error for any path outside; it does not reveal whether the path exists."""
    return ForbiddenError(
        "path: expected a file or folder under the folders that may be imported from: those of "
        "the option --import-roots, or the home folder and the folder that the server started in"
    )


def _is_hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def _links(path: Path) -> Iterator[Path]:
    """Yield every link below a folder, also in the targets of links."""
    seen = set()
    waiting = [str(path)]
    while waiting:
        for folder, folders, files in os.walk(waiting.pop()):
            for inner in (Path(folder, name) for name in (*folders, *files)):
                if not inner.is_symlink() or inner.name.startswith("."):
                    continue  # hidden files are never read
                yield inner
                real = os.path.realpath(inner)
                if real not in seen:
                    seen.add(real)
                    waiting.append(real)


def allowed(given: str, roots: Sequence[Path]) -> list[Path]:
    """Return the paths that ``given`` (a path or a glob) names under the resolved ``roots``.

    Raises ForbiddenError for a path that is or leads outside, or is hidden, always with the same
    text, so that it does not reveal existing files; NotFoundError for a missing path inside.
    """
    path = Path(os.path.normpath(Path.cwd() / given))
    if not is_inside(path, roots):
        raise outside()
    if os.path.lexists(path):
        return [Path(os.path.realpath(path))]
    found: list[Path] = []
    for pattern in _beginnings(path) if glob.has_magic(given) else ():
        # Part by part, so that the target of a link to the outside is never read.
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
    """Return the error for an allowed path that does not exist."""
    return NotFoundError("path: expected a file or folder, there is none of this name")
