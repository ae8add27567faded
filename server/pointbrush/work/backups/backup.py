"""Backing up and restoring a workspace, and moving its labels to another database.

A file in the workspace has the URL of the database to which its labels were moved.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import shutil
import stat
import uuid
from itertools import chain, count
from pathlib import Path
from typing import Any

from sqlalchemy import make_url

from pointbrush.database.backup import back_up, move, restore, restore_file, restore_sequence
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, UnavailableError
from pointbrush.names import is_plain
from pointbrush.sequences.storage.manifest import rename_sequence
from pointbrush.system.resources import shortages_as_unavailable
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.work.imports.uploads import any_alive
from pointbrush.work.library import Library

log = logging.getLogger(__name__)

NOTE = "database.json"
DATABASE = "labels.sqlite"
MADE = "labels.made"
"""Marker file of a workspace that has, or had, its own database of labels."""
RECORDINGS = "sequences"
CLASSIFIERS = "classifiers"
STUDIES = "studies"


def own_url(workspace: Path) -> str:
    """Return the URL of a workspace's own SQLite file."""
    return f"sqlite:///{(workspace / 'labels.sqlite').absolute()}"


def note_database(workspace: Path, url: str) -> None:
    """Write the URL of the labels without its password."""
    text = "" if url == own_url(workspace) else _public(url)
    partial = workspace / f".{NOTE}"
    partial.write_text(json.dumps({"database": text}), encoding="utf-8")
    partial.replace(workspace / NOTE)


def require_noted_database(workspace: Path, url: str) -> None:
    """Raise BadInputError if the labels were moved to another database than ``url``."""
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
            f"(or remove {NOTE} to ignore the move)"
        )


def require_labels(workspace: Path, url: str, recordings: int, *, anew: bool) -> None:
    """Raise BadInputError if the workspace's own database of labels is missing.

    The marker file shows that it existed; without the marker, a warning is logged.  ``recordings``:
    their number; ``anew``: a new database is wanted.
    """
    if url != own_url(workspace) or _has_bytes(workspace / DATABASE) or not recordings or anew:
        return
    state = "empty" if (workspace / DATABASE).exists() else "missing"
    found = f"{DATABASE} is {state} beside {recordings} recordings"
    if not (workspace / MADE).exists():
        log.warning("%s: their labels begin empty; if there were some, restore a backup", found)
        return
    raise BadInputError(
        f"workspace: {found} whose labels it holds; bring it back, restore a backup (pointbrush "
        "restore BACKUP --workspace NEW), or begin with empty labels by serve --new-labels"
    )


def _has_bytes(file: Path) -> bool:
    return file.exists() and file.stat().st_size > 0


def note_made(workspace: Path, url: str) -> None:
    """Create the marker file of the workspace's own database of labels."""
    if url == own_url(workspace) and not (workspace / MADE).exists():
        with contextlib.suppress(OSError):  # a read-only workspace
            (workspace / MADE).write_text(f"{DATABASE} holds the labels\n", encoding="utf-8")


def _public(url: str) -> str:
    return make_url(url).set(password=None).render_as_string(hide_password=False)


def _place(url: str) -> tuple[Any, ...]:
    parsed = make_url(url)
    if parsed.get_backend_name() == "sqlite":
        return "sqlite", str(Path(str(parsed.database)).absolute())
    return "postgresql", parsed.host, parsed.port or 5432, parsed.database


def is_backup(folder: Path) -> bool:
    """Return whether a folder is a backup."""
    return (folder / DATABASE).is_file()


def make_backup(
    store: WorkspaceStore,
    library: Library,
    target: Path,
    workspace: Path | None = None,
    earlier: Path | None = None,
) -> None:
    """Copy a workspace in use into the new folder ``target``.

    The database is copied last, so that all its recordings are in the copy.  ``workspace``: its
    folder, with classifiers and studies.  ``earlier``: a backup on the same disk; files that it has
    become hard links to it.  Raises ConflictError when ``target`` exists.
    """
    partial = _partial(target)
    try:
        for manifest in library.manifests():
            place = Path(RECORDINGS, manifest.id)
            before = None if earlier is None else earlier / place
            library.store.files(manifest.id).copy_to(partial / place, before)
        if workspace is not None:
            for part in (CLASSIFIERS, STUDIES):
                _copy(workspace / part, partial / part)
        back_up(store.database, partial / DATABASE)
        os.sync()  # the data must be on the disk before the final name
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def restore_backup(source: Path, target: Path, url: str = "") -> None:
    """Create the workspace ``target`` from a backup, with its labels in the database at ``url``.

    Without ``url`` they are in the workspace.  Raises NotFoundError when ``source`` is no backup,
    ConflictError when ``target`` exists or the database is not empty.
    """
    if not is_backup(source):
        raise NotFoundError(f"backup: expected a folder with {DATABASE}, got {source}")
    partial = _partial(target)
    try:
        for part in (RECORDINGS, CLASSIFIERS, STUDIES):
            _copy_plain(source / part, partial / part)
        if url:
            note_database(partial, url)
            restore(source / DATABASE, url)
        else:
            restore_file(source / DATABASE, partial / DATABASE)
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def restore_one(store: WorkspaceStore, library: Library, source: Path, sequence: str) -> str:
    """Restore one recording of a backup into a workspace, even one in use; return its id.

    Its labels, history and tracks are restored too.  If its id is taken, it gets a free one.
    Raises NotFoundError when the backup does not have it.
    """
    folder = source / RECORDINGS / sequence
    if not is_plain(sequence) or not folder.is_dir():
        raise NotFoundError(f"backup: expected a recording of {source}, got {sequence!r}")
    known = [*store.recordings.live(), *store.recordings.deleted()]
    taken = {one.id for one in known}
    ids = chain([sequence], (f"{sequence}-{number}" for number in count(2)))
    guard = store.guards.reserve(ids, lambda id_: id_ not in taken and library.is_free(id_))
    target = guard.sequence
    try:
        with library.store.staging() as partial:
            _copy_plain(folder, partial)
            identity = rename_sequence(partial, target).identity
            numbers = restore_sequence(
                source / DATABASE,
                store.database,
                sequence,
                target,
                identity,
                lambda: library.store.publish(partial, target),
            )
    finally:
        store.guards.end(guard)
    for dataset, classes in numbers.items():
        store.taxonomy.learn(dataset, classes, strict=False)
    return target


def move_labels(workspace: Path, source_url: str, target_url: str) -> None:
    """Move a workspace's labels into the empty database at ``target_url``, in one transaction.

    The workspace stores the new URL.  The old database is kept; a SQLite file of the workspace is
    renamed.  Raises ConflictError while a server runs here, or if the target is not empty.
    """
    if source_url == target_url:
        raise ConflictError("move: expected another database, got the one that holds the labels")
    if any_alive(workspace):
        raise ConflictError(
            "move: expected no running server on this workspace; stop it first, or wait a minute "
            "after it was killed on another machine"
        )
    move(source_url, target_url)
    note_database(workspace, target_url)
    old = workspace / DATABASE
    if source_url == own_url(workspace):
        for suffix in ("-wal", "-shm"):
            old.with_name(old.name + suffix).unlink(missing_ok=True)
        old.rename(old.with_name(f"{old.name}.moved-{uuid.uuid4().hex[:8]}"))


def _partial(target: Path) -> Path:
    if target.exists():
        raise ConflictError(f"target: expected a new folder, {target} exists")
    partial = target.absolute().with_name(f".{target.name}.partial-{os.getpid()}")
    shutil.rmtree(partial, ignore_errors=True)
    (partial / RECORDINGS).mkdir(parents=True)
    return partial


def _copy_plain(source: Path, target: Path) -> None:
    """Copy a part of a backup, if it exists.

    Raises BadInputError for special files and links in it and for unreadable files,
    UnavailableError if the disk is full.
    """
    if not os.path.lexists(source):
        return
    size, room = _plain_bytes(source), shutil.disk_usage(target.parent).free
    if size > room:
        raise UnavailableError(
            f"restore: {source.name} of the backup takes {size:,} bytes, the disk has {room:,}"
        )
    try:
        with shortages_as_unavailable():
            shutil.copytree(source, target, symlinks=True, dirs_exist_ok=True)
    except OSError as error:
        reason = error.args[0][0][2] if isinstance(error, shutil.Error) else error
        raise BadInputError(f"backup: expected files that can be read, got: {reason}") from None


def _plain_bytes(folder: Path) -> int:
    """Return the size of the files in a folder; raises BadInputError for links, pipes, devices."""
    size = 0
    found = (Path(place, name) for place, *names in os.walk(folder) for name in chain(*names))
    for path in chain([folder], found):
        status = path.lstat()
        if stat.S_ISREG(status.st_mode):
            size += status.st_size
        elif not stat.S_ISDIR(status.st_mode):
            place = path.relative_to(folder.parent)
            raise BadInputError(
                f"backup: expected folders and files, got a link or a special file: {place}"
            )
    return size


def _copy(source: Path, target: Path) -> None:
    if source.is_dir():
        shutil.copytree(source, target, dirs_exist_ok=True)
