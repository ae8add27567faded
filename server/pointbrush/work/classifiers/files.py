"""Classifiers as files in a folder of the workspace."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

from pointbrush.classify.classifier import Classifier, from_file, to_file
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.sequences.storage.files import replace_file
from pointbrush.work.trash import ids_for

_ID = re.compile(r"[a-z0-9][a-z0-9._-]{0,63}")
_ENDING = ".npz"
MOST_CLASSIFIERS = 256
"""Limit for a workspace, as listing reads each file for its training recordings."""


class ClassifierFiles:
    """One file per classifier in ``folder``, which need not exist."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def ids(self) -> list[str]:
        """Return the ids of all classifiers, sorted."""
        found = (path.name.removesuffix(_ENDING) for path in self._folder.glob(f"*{_ENDING}"))
        return sorted(name for name in found if _ID.fullmatch(name))

    def read(self, identifier: str) -> Classifier:
        """Return a classifier; raises NotFoundError, BadInputError for a damaged file."""
        try:
            return from_file(self._path(identifier).read_bytes(), stored=True)
        except FileNotFoundError:
            raise unknown(identifier) from None

    def problems(self) -> list[str]:
        """Return a sentence for each file that cannot be read as a classifier."""
        found = []
        for identifier in self.ids():
            with suppress(NotFoundError):  # deleted meanwhile
                try:
                    self.read(identifier)
                except (BadInputError, OSError) as error:
                    found.append(f"{self._folder.name}/{identifier}{_ENDING}: {error}")
        return found

    def free_id(self, name: str) -> str:
        """Return a free readable id for a name.  Raises BadInputError at the limit."""
        taken = set(self.ids())
        if len(taken) >= MOST_CLASSIFIERS:
            raise BadInputError(
                f"classifiers: expected at most {MOST_CLASSIFIERS} in a workspace, delete one first"
            )
        return next(each for each in ids_for(name) if each not in taken)

    def write(self, identifier: str, classifier: Classifier) -> None:
        """Write a classifier atomically."""
        path = self._path(identifier)
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, to_file(classifier))

    def delete(self, identifier: str) -> None:
        """Remove a classifier; raises NotFoundError."""
        try:
            self._path(identifier).unlink()
        except FileNotFoundError:
            raise unknown(identifier) from None

    def _path(self, identifier: str) -> Path:
        if not _ID.fullmatch(identifier):
            raise unknown(identifier)
        return self._folder / f"{identifier}{_ENDING}"


def unknown(identifier: str) -> NotFoundError:
    """Return the error for an unknown id."""
    return NotFoundError(f"classifier: expected a known id, got {identifier!r}")
