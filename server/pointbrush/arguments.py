"""Secrets on the command line: every user of a machine may read a process's arguments."""

from __future__ import annotations

import os
import sys
from urllib.parse import parse_qs, urlsplit

from pointbrush.errors import BadInputError
from pointbrush.options import PREFIX

VARIABLE = f"{PREFIX}DATABASE"


def has_password(url: str) -> bool:
    """Return whether a database URL holds a password."""
    parts = urlsplit(url)
    return bool(parts.password) or "password" in parse_qs(parts.query)


def hide_password(url: str | None) -> None:
    """Start this program again with the URL of ``--database`` in its environment, if it is secret.

    The arguments could be read until then: a warning says so.  Raises BadInputError where a
    program cannot be replaced by itself.
    """
    if url is None or not has_password(url):
        return
    if os.name != "posix":
        raise BadInputError(f"--database: expected no password in it; set {VARIABLE} instead")
    print(
        "pointbrush: the password in --database could be read by other users of this machine "
        f"while the program began; set {VARIABLE}, --database-password-file or PGPASSFILE instead",
        file=sys.stderr,
        flush=True,
    )
    kept = without_database(sys.orig_argv[1:])
    os.execve(  # noqa: S606 – this very program
        sys.executable, [sys.executable, *kept], os.environ | {VARIABLE: url}
    )


def without_database(arguments: list[str]) -> list[str]:
    """Return ``arguments`` without ``--database URL`` or ``--database=URL``."""
    kept: list[str] = []
    rest = iter(arguments)
    for argument in rest:
        if argument == "--database":
            next(rest, None)
        elif not argument.startswith("--database="):
            kept.append(argument)
    return kept
