"""Characters that no name may hold: they hide, or change how the text around them is read."""

from __future__ import annotations

import re

from pointbrush.errors import BadInputError

HIDDEN = r"\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069"
"""Control, line breaking and bidirectional characters, as the inside of a regular expression's
class: Python's, JavaScript's and Rust's read it alike."""
_HIDDEN = re.compile(f"[{HIDDEN}]")


def require_visible(field: str, name: str) -> None:
    """Raise BadInputError naming ``field`` where a name holds one of the characters."""
    if _HIDDEN.search(name):
        raise BadInputError(
            f"{field}: expected no control or bidirectional characters, "
            f"got '{spelled_out(name[:80])}'"
        )


def spelled_out(name: str) -> str:
    r"""Return a name with each of the characters written as its escape, such as ``\u202e``.

    Names that come in files are kept so: the file is not refused, and nobody is misled.
    """
    return _HIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), name)
