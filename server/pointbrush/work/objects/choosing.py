"""Selectors of a workspace, for all recordings or for single ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

from pointbrush.errors import BadInputError
from pointbrush.selection.selectors import BUILT_IN, Selector, make_selector


@dataclass(frozen=True, eq=False)
class Chosen:
    """A selector and the name by which another process can create it."""

    name: str

    @cached_property
    def selector(self) -> Selector:
        """Return the selector, created at its first use.  Raises BadInputError."""
        return make_selector(self.name)


@dataclass(frozen=True, eq=False)
class Selectors:
    """Selectors by a recording's id; ``common`` is used for other recordings."""

    common: Chosen
    own: Mapping[str, Chosen]

    @classmethod
    def parse(cls, text: str) -> Selectors:
        """Parse ``NAME`` and ``RECORDING=NAME``, separated by commas.

        Raises BadInputError for an unknown selector and for a recording named twice.
        """
        named: dict[str, str] = {}
        for entry in filter(None, (part.strip() for part in text.split(","))):
            recording, equals, name = entry.partition("=")
            # An address may hold '=' as well; an id holds neither ':' nor '/'.
            if not equals or ":" in recording or "/" in recording:
                recording, name = "", entry
            if recording in named:
                twice = f"recording '{recording}'" if recording else "all recordings"
                raise BadInputError(f"selector: expected one for {twice}, got two")
            named[recording] = name
        made: dict[str, Chosen] = {}
        for name in {*named.values(), BUILT_IN}:
            made[name] = Chosen(name)
            if name != BUILT_IN:  # always exists, and is slow to import
                _ = made[name].selector
        common = made[named.pop("", BUILT_IN)]
        return cls(common, MappingProxyType({key: made[name] for key, name in named.items()}))

    def every(self) -> set[Chosen]:
        """Return the distinct selectors."""
        return {self.common, *self.own.values()}

    def of(self, recording: str) -> Chosen:
        """Return the selector for a recording's id."""
        return self.own.get(recording, self.common)
