"""Connection of a run's two processes: objects by pickle, shared ones by name."""

from __future__ import annotations

import pickle
from typing import IO, cast

GONE = (EOFError, OSError, pickle.UnpicklingError)
"""What shows that the other process has ended."""


class _Elsewhere:
    """Stands for what only the other process has."""


class Names:
    """Objects that both processes have, by name."""

    def __init__(self) -> None:
        self._kept: dict[int, tuple[object, object]] = {}
        self._named: dict[object, object] = {}

    def add(self, name: object, value: object) -> None:
        """Give ``value`` a name, which what had it before loses."""
        if name in self._named:
            self._kept.pop(id(self._named[name]), None)
        self._kept[id(value)] = (name, value)
        self._named[name] = value

    def drop(self, name: object) -> None:
        """Forget a name."""
        self._kept.pop(id(self._named.pop(name, None)), None)

    def name(self, value: object) -> object:
        """The name that a value has, None for none."""
        found = self._kept.get(id(value))
        return None if found is None else found[0]

    def value(self, name: object) -> object:
        """Return what has the name; something that stands for it where only the other process
        has it."""
        if name not in self._named:
            self.add(name, _Elsewhere())
        return self._named[name]


class _Pickler(pickle.Pickler):
    def __init__(self, file: IO[bytes], names: Names) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._names = names

    def persistent_id(self, value: object) -> object:
        """See ``pickle.Pickler``."""
        return self._names.name(value)


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: IO[bytes], names: Names) -> None:
        super().__init__(file)
        self._names = names

    def persistent_load(self, name: object) -> object:
        """See ``pickle.Unpickler``."""
        return self._names.value(name)


class Connection:
    """One end: what is sent goes by pickle, or by its name where the other end has it already."""

    def __init__(self, incoming: IO[bytes], outgoing: IO[bytes]) -> None:
        self._incoming, self._outgoing = incoming, outgoing
        self.names = Names()

    def send(self, message: object) -> None:
        """Send a message at once."""
        _Pickler(self._outgoing, self.names).dump(message)
        self._outgoing.flush()

    def receive(self) -> object:
        """The next message; waits for it."""
        return cast(object, _Unpickler(self._incoming, self.names).load())
