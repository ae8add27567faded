"""Names: characters that none may hold, as they change how text is read, and equal spellings."""

from __future__ import annotations

import os
import re
import unicodedata
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.values.kinds import HIDDEN

SCRATCH = "headset_check"
"""Id of the recording for headset checks; ids made from names have no underscore."""
_HIDDEN = re.compile(f"[{HIDDEN}]")


def require_visible(field: str, name: str) -> None:
    """Raise BadInputError naming ``field`` where a name holds one of the characters."""
    if _HIDDEN.search(name):
        raise BadInputError(
            f"{field}: expected no control or bidirectional characters, "
            f"got '{spelled_out(name[:80])}'"
        )


def is_plain(name: str | None) -> bool:
    """Return whether a name, as of a file, stays in the folder that it is joined to."""
    return name is None or (os.path.split(name) == ("", name) and name[:1] not in ("", "."))


def spelled_out(name: str) -> str:
    r"""Return a name with each of the characters written as its escape, such as ``\u202e``.

    Names that come in files are kept so: the file is not refused, and nobody is misled.  The name
    is composed, too.
    """
    return _HIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), composed(name))


def composed(name: str) -> str:
    """Return a name with accents composed (NFC): macOS writes é as two characters, Linux as one."""
    return name if name.isascii() else unicodedata.normalize("NFC", name)


def stored_as(path: Path) -> Path:
    """Return the path of an existing file whose name is equal once composed, else ``path``."""
    if path.exists() or path.name.isascii() or not path.parent.is_dir():
        return path
    name = composed(path.name)
    return next((each for each in path.parent.iterdir() if composed(each.name) == name), path)
