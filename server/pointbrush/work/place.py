"""Note in a workspace of the database that its labels were moved to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from sqlalchemy import make_url

from pointbrush.errors import BadInputError

NOTE = "database.json"


def own_url(workspace: Path) -> str:
    """Return the URL of the SQLite file that a workspace has of its own."""
    return f"sqlite:///{(workspace / 'labels.sqlite').absolute()}"


def note_database(workspace: Path, url: str) -> None:
    """Write where the labels are now; a password is left out."""
    text = "" if url == own_url(workspace) else _public(url)
    partial = workspace / f".{NOTE}"
    partial.write_text(json.dumps({"database": text}), encoding="utf-8")
    partial.replace(workspace / NOTE)


def require_here(workspace: Path, url: str) -> None:
    """Raise BadInputError when the labels are known to be in another database than ``url``."""
    try:
        noted = json.loads((workspace / NOTE).read_text(encoding="utf-8"))["database"]
    except FileNotFoundError:
        return
    except (OSError, ValueError, KeyError, TypeError):
        raise BadInputError(
            f"workspace: expected a note of its database in {NOTE}, got something else"
        ) from None
    if _place(noted or own_url(workspace)) != _place(url):
        start = f"--database {noted}" if noted else "no --database: they are in the workspace"
        raise BadInputError(
            f"database: the labels of this workspace were moved; start with {start} "
            f"(or remove {NOTE} if you know better)"
        )


def _public(url: str) -> str:
    return make_url(url).set(password=None).render_as_string(hide_password=False)


def _place(url: str) -> tuple[Any, ...]:
    parsed = make_url(url)
    if parsed.get_backend_name() == "sqlite":
        return "sqlite", str(Path(str(parsed.database)).absolute())
    return "postgresql", parsed.host, parsed.port or 5432, parsed.database
