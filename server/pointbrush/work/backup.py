"""Backups: recordings are immutable and copied or linked, the database is copied consistently."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from pointbrush.errors import ConflictError, NotFoundError
from pointbrush.labels import LabelStore
from pointbrush.work.library import Library

DATABASE = "labels.sqlite"
RECORDINGS = "sequences"


def make_backup(store: LabelStore, library: Library, target: Path) -> None:
    """Copy everything into the new folder ``target``, while the workspace is in use.

    The database is copied last, so that it never knows of a recording that is not there.
    Raises ConflictError when ``target`` exists.
    """
    partial = _partial(target)
    try:
        for manifest in library.manifests():
            _copy(library.folder / manifest.id, partial / RECORDINGS / manifest.id)
        store.backup(partial / DATABASE)
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def restore_backup(source: Path, target: Path) -> None:
    """Make the new workspace ``target`` from a backup.

    Raises NotFoundError when ``source`` is none, ConflictError when ``target`` exists.
    """
    if not (source / DATABASE).is_file():
        raise NotFoundError(f"backup: expected a folder with {DATABASE}, got {source}")
    partial = _partial(target)
    try:
        _copy(source / RECORDINGS, partial / RECORDINGS)
        shutil.copy2(source / DATABASE, partial / DATABASE)
        partial.rename(target)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _partial(target: Path) -> Path:
    if target.exists():
        raise ConflictError(f"target: expected a new folder, {target} exists")
    partial = target.absolute().with_name(f".{target.name}.partial-{os.getpid()}")
    shutil.rmtree(partial, ignore_errors=True)
    (partial / RECORDINGS).mkdir(parents=True)
    return partial


def _copy(source: Path, target: Path) -> None:
    if source.is_dir():
        shutil.copytree(source, target, dirs_exist_ok=True)
