"""The server, its state, and the caller."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Rule, Value
from pointbrush.values.kinds import Role

Command = Annotated[str, Rule(min_length=1, max_length=128)]
CommandKey = Annotated[str, Rule(min_length=1, max_length=32)]


@dataclass(frozen=True, slots=True)
class SignIn(Body):
    """Sign in with a token."""

    token: Annotated[str, Rule(min_length=1, max_length=512)]
    """Token of an account, as the server or a manager printed it."""


@dataclass(frozen=True, slots=True)
class SignedIn(Value):
    """The signed-in person."""

    author: str
    """Name that edits show."""
    role: Role
    """Role in the workspace."""


@dataclass(frozen=True, slots=True)
class Me(SignedIn):
    """The caller, and the messages that the server speaks."""

    schema: str
    """Hash of the socket's messages, part of its subprotocol."""
    version: str
    """Version of the server."""


@dataclass(frozen=True, slots=True)
class NewKeys(Body):
    """Keyboard shortcuts of the caller, which replace the earlier ones."""

    keys: Annotated[Mapping[Command, CommandKey], Rule(max_length=256)]
    """Keys by the text of the command."""


@dataclass(frozen=True, slots=True)
class OwnKeys(Value):
    """Keyboard shortcuts of the caller."""

    keys: Mapping[str, str] | None
    """Keys by the text of the command; null: the caller has never chosen any."""


@dataclass(frozen=True, slots=True)
class Health(Value):
    """The server is up."""

    status: Annotated[Literal["ok"], Meanings({"ok": "the server answers"})]
    """State of the server."""
    version: str
    """Version of the server."""


@dataclass(frozen=True, slots=True)
class Ready(Value):
    """Readiness of the server for work."""

    status: Annotated[
        Literal["ready", "not ready"],
        Meanings({"ready": "all parts work", "not ready": "a part has a fault"}),
    ]
    """State of the whole."""
    parts: Mapping[str, str]
    """``ok`` or the fault of each part, by its name."""
