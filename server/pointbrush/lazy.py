"""Names that are imported, and parts that are made, when first asked for: commands start early."""

from __future__ import annotations

import inspect
import re
import sys
import threading
from collections.abc import Callable
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar

Part = TypeVar("Part")
IMPORT = re.compile(r"^ +from (\S+) import (?:\(([^)]*)\)|(.*))$", re.M)
"""An import for type checkers.  Two threads may import packages at once, but CPython 3.11 fails if
two parse syntax trees at once."""


def lazily(package: str) -> Callable[[str], Any]:
    """Return a ``__getattr__`` of ``package`` for the names that it imports for type checkers."""
    source = inspect.getsource(sys.modules[package])
    places = {
        name: module
        for module, several, one in IMPORT.findall(source)
        if module.startswith(f"{package}.")
        for name in re.findall(r"\w+", several or one)
    }

    def find(name: str) -> Any:
        place = places.get(name)
        if place is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(place), name)
        setattr(import_module(package), name, value)
        return value

    return find


class once(cached_property[Part]):  # noqa: N801 – a decorator
    """A part of an object that is made when first asked for, whichever threads ask at a time."""

    def __init__(self, make: Callable[[Any], Part]) -> None:
        super().__init__(make)
        self._making = threading.RLock()

    if not TYPE_CHECKING:

        def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
            # Python's own makes it twice since 3.12, for two threads.
            with self._making:
                return super().__get__(instance, owner)

    def made(self, instance: object) -> bool:
        """Return whether ``instance`` has the part."""
        return self.attrname in vars(instance)
