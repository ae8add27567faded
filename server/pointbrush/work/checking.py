"""Is everything in a workspace as it was written, and what can be made anew of what is not?"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from pointbrush.errors import NotFoundError, ReadOnlyError, UnavailableError
from pointbrush.labels import LabelStore
from pointbrush.sequences import note_checksums, verify
from pointbrush.work.library import LABELS_ALONE, Library


@dataclass(slots=True)
class Repaired:
    """Faults that are repaired, and what is lost; one sentence each."""

    rebuilt: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)


def check_recording(library: Library, store: LabelStore, sequence: str) -> list[str]:
    """List faults of a recording's files, journal and annotations; none when it is sound."""
    problems = verify(library.store.files(sequence))
    try:
        return problems + store.check(sequence)
    except (UnavailableError, NotFoundError) as error:
        return [*problems, f"its labels cannot be read: {error}"]


def repair(library: Library, store: LabelStore, sequences: Iterable[str]) -> Repaired:
    """Make anew what can be; no other process may have the workspace open.

    Indexes come from the database's rows; snapshots, counts, palette and tracks from the journal.
    Files of frames, the journal and manifests cannot be made anew.  Raises ReadOnlyError.
    """
    done = Repaired()
    _repair_database(store, done)
    if done.lost:
        return done
    for sequence in sequences:
        _repair_labels(store, sequence, done)
        if not library.has(sequence):
            done.lost.append(f"{sequence}: {LABELS_ALONE}")
            continue
        files = library.store.files(sequence)
        if note_checksums(files):
            done.rebuilt.append(
                f"{sequence}: it had no checksums; those of its files as they are now are kept"
            )
        done.lost += [
            f"{sequence}: {line}; import it again or restore it from a backup"
            for line in verify(files)
        ]
    return done


def _repair_database(store: LabelStore, done: Repaired) -> None:
    found = store.integrity()
    if not found:
        return
    try:
        store.rebuild_indexes()
    except ReadOnlyError:
        raise
    except UnavailableError as error:
        found = [*found, f"database: its indexes cannot be made anew: {error}"]
    else:
        left = store.integrity()
        done.rebuilt += [line for line in found if line not in left]
        found = left
    done.lost += [f"{line}; restore it from a backup" for line in found]


def _repair_labels(store: LabelStore, sequence: str, done: Repaired) -> None:
    try:
        rebuilt, lost = store.repair(sequence)
    except (UnavailableError, NotFoundError) as error:
        rebuilt, lost = [], [f"its labels cannot be read: {error}"]
    done.rebuilt += [f"{sequence}: {line}" for line in rebuilt]
    done.lost += [
        f"{sequence}: {line}; nothing of its labels was changed, restore them from a backup"
        for line in lost
    ]
