"""Names of users' own models: services that the operator allows, and installed plug-ins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from typing import Any, ClassVar, Self

from pointbrush.errors import BadInputError


@dataclass(frozen=True, slots=True)
class ModelNames:
    """Models that may be used: services, with ``addresses`` by name, and installed plug-ins."""

    GROUP: ClassVar[str]
    """Group of the entry points of plug-ins."""
    OPTION: ClassVar[str]
    """Option of the server with the addresses."""

    addresses: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the services of ``NAME=ADDRESS``, separated by commas; raises BadInputError."""
        addresses: dict[str, str] = {}
        for entry in filter(None, (part.strip() for part in text.split(","))):
            name, _, address = entry.partition("=")
            if not name.isidentifier() or not address.startswith(("http://", "https://")):
                raise BadInputError(f"{cls.OPTION}: expected NAME=http://host…, got {entry!r}")
            if name in addresses:
                raise BadInputError(f"{cls.OPTION}: expected one address for {name}, got two")
            addresses[name] = address
        return cls(addresses)

    def names(self) -> list[str]:
        """Return the names of all models, sorted."""
        return sorted({*self.addresses, *(entry.name for entry in entry_points(group=self.GROUP))})

    def address(self, name: str) -> str | None:
        """Return the address of a service, None for a plug-in; raises BadInputError (unknown)."""
        if name not in self.names():
            expected = ", ".join(self.names()) or "none, as this server has none"
            raise BadInputError(f"model: expected one of {expected}; got {name!r}")
        return self.addresses.get(name)

    @classmethod
    def plug_in(cls, name: str) -> Any:
        """Return a new instance of an installed plug-in."""
        return next(iter(entry_points(group=cls.GROUP, name=name))).load()()
