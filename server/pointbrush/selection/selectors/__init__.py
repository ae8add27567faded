"""Selectors, which return regions for clicks: built-in, from plug-ins, and over HTTP.

A package adds one with an entry point of the group ``pointbrush.selectors`` that names a class or
function; called without arguments, it returns a ``Selector``.
"""

from __future__ import annotations

from importlib.metadata import entry_points

from pointbrush.errors import BadInputError
from pointbrush.selection.selectors.interface import (
    Mask,
    Region,
    Selector,
    StateLostError,
    StoredSelector,
)

__all__ = [
    "BUILT_IN",
    "Mask",
    "Region",
    "Selector",
    "StateLostError",
    "StoredSelector",
    "make_selector",
]

GROUP = "pointbrush.selectors"
BUILT_IN = "tree"


def make_selector(name: str) -> Selector:
    """Return the selector of a name: ``tree``, an entry point's, or an http(s) address.

    Raises BadInputError for an unknown name.
    """
    # Imported here, because they load compiled loops.
    if name == BUILT_IN:
        from pointbrush.selection.selectors.tree import TreeSelector

        return TreeSelector()
    if name.startswith(("http://", "https://")):
        from pointbrush.selection.selectors.http import HttpSelector

        return HttpSelector(name)
    known = {entry.name: entry for entry in entry_points(group=GROUP)}
    if name not in known:
        expected = ", ".join([BUILT_IN, *sorted(known), "http://…"])
        raise BadInputError(f"selector: expected one of {expected}, got {name!r}")
    made: Selector = known[name].load()()
    return made
