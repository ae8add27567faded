"""Whether a path stays under given folders, links followed, and shows itself."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from pointbrush.errors import ForbiddenError


def is_inside(path: Path, roots: Sequence[Path]) -> bool:
    """Whether ``path`` lies under one of ``roots`` (resolved), also where its links lead to, and
    nothing on the way is hidden.

    It need not be there: a link on the way that leads out does so also where nothing is behind it.
    """
    real = Path(os.path.realpath(path))
    named = [path.relative_to(root) for root in roots if path.is_relative_to(root)]
    if named and all(_is_hidden(below) for below in named):
        return False
    return any(
        real.is_relative_to(root) and not _is_hidden(real.relative_to(root)) for root in roots
    )


def require_inside(paths: Sequence[Path], roots: Sequence[Path]) -> None:
    """Raise ForbiddenError unless ``paths``, and all that links below them lead to, are inside."""
    for path in paths:
        if not all(is_inside(found, roots) for found in (path, *_links(path))):
            raise outside()


def outside() -> ForbiddenError:
    """The one answer to whatever is not inside: it tells nothing of what is there."""
    return ForbiddenError(
        "path: expected a file or folder under the folders that may be imported from "
        "(see the option import_roots)"
    )


def _is_hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def _links(path: Path) -> Iterator[Path]:
    """Every link below a folder, also in folders that links lead to."""
    seen = set()
    waiting = [str(path)]
    while waiting:
        for folder, folders, files in os.walk(waiting.pop()):
            for inner in (Path(folder, name) for name in (*folders, *files)):
                if not inner.is_symlink() or inner.name.startswith("."):
                    continue  # hidden ones are never read
                yield inner
                real = os.path.realpath(inner)
                if real not in seen:
                    seen.add(real)
                    waiting.append(real)
