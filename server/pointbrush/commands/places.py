"""The place where a command works: a workspace of this machine, or a server."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

from pointbrush.commands.following import Job, follow
from pointbrush.errors import BadInputError
from pointbrush.settings.command_sets import CLIENTS, LOCAL, REMOTE, STORAGE, WORKSPACE
from pointbrush.settings.settings import Settings, options

if TYPE_CHECKING:
    from pointbrush.client import Client
    from pointbrush.commands.local import LocalClient

Place: TypeAlias = "LocalClient | Client"
MAKERS = (("demo", None), ("serve", None), ("import", None), ("token", "add"))
"""Commands with their action that make a workspace."""


def place_of(given: argparse.Namespace, settings: Settings) -> Place:
    """Return the place where a command works; raises BadInputError, see ``_on_server``.

    Raises BadInputError for no address of a server, or no token.
    """
    if _on_server(given, settings):
        from pointbrush.client import Client

        return Client(settings.server, settings.token)
    from pointbrush.commands.local import LocalClient

    makes = (given.command, getattr(given, "action", None)) in MAKERS
    return LocalClient(settings, makes=makes)


def finished(place: Place, job: Job) -> dict[str, Any]:
    """Show a job until it has ended, also while its server restarts; return its result."""
    from pointbrush.commands.local import LocalClient

    if isinstance(place, LocalClient):
        return follow(place.job, job)
    from pointbrush.client import PATIENCE

    return follow(partial(place.job, patience=PATIENCE), job)


def _on_server(given: argparse.Namespace, settings: Settings) -> bool:
    """Return whether a command works on a server's workspace, not on one of this machine.

    Flags of a workspace or its storage win over POINTBRUSH_SERVER.  Raises BadInputError if the
    command cannot work where the flags and the environment say.
    """
    command, local = given.command, _storage_flag(given)
    if local and getattr(given, "server", None):
        raise BadInputError(f"--server: expected no {local}, which names a workspace here")
    if command in CLIENTS and command not in REMOTE and not settings.server:
        raise BadInputError(
            f"pointbrush {command} works on a server: give --server URL or set POINTBRUSH_SERVER; "
            "`pointbrush serve` starts a server of a workspace"
        )
    if not settings.server or local:
        return False
    if command in LOCAL:
        raise BadInputError(
            f"pointbrush {command} works on a workspace's folder; POINTBRUSH_SERVER is set: unset "
            "it or give --workspace"
        )
    return command in CLIENTS


def _storage_flag(given: argparse.Namespace) -> str:
    """Return the first given flag of a workspace or its storage, or ""."""
    storage = (each for each in options() if each.definition.group in (WORKSPACE, STORAGE))
    found = (each.flag for each in storage if getattr(given, each.name, None) is not None)
    return next(found, "")
