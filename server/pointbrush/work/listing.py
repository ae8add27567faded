"""All recordings of a workspace, whole or not, and what is wrong with those that are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pointbrush.errors import NotFoundError, PointbrushError, UnavailableError
from pointbrush.labels import LabelStore
from pointbrush.sequences import Manifest, verify
from pointbrush.work import checking
from pointbrush.work.deletion import Deletion
from pointbrush.work.imports.submitting import Imports
from pointbrush.work.library import LABELS_ALONE, Library


@dataclass(frozen=True, slots=True)
class Listed:
    """A recording; ``manifest`` is None when it cannot be read, ``damaged`` a sentence or None.

    ``labelled`` is the number of its frames with labelled points.
    """

    id: str
    revision: int
    manifest: Manifest | None
    damaged: str | None
    labelled: int = 0

    @property
    def name(self) -> str:
        """Its name."""
        return self.id if self.manifest is None else self.manifest.name


def listing(
    library: Library, store: LabelStore, imports: Imports, deletion: Deletion
) -> list[Listed]:
    """Every recording that has files or labels, by name; not those that imports have begun."""
    found, revisions = library.survey(), store.sequences()
    if revisions.keys() != {folder.id for folder in found}:
        # A deletion or an import was stopped, here or by another server.
        deletion.tidy()
        found = library.survey()
        imports.complete([one.manifest for one in found if one.manifest is not None])
        revisions = store.sequences()
    importing = store.guards.importing() if revisions.keys() != {one.id for one in found} else ()
    labelled = store.labelled_frames()
    entries = [
        Listed(one.id, revisions.get(one.id, 0), one.manifest, one.damaged, labelled.get(one.id, 0))
        for one in found
        if one.id in revisions or one.id not in importing
    ]
    alone = revisions.keys() - {one.id for one in found}
    entries += [Listed(name, revisions[name], None, LABELS_ALONE) for name in alone]
    return sorted(entries, key=lambda entry: (entry.name.lower(), entry.id))


def entry(library: Library, store: LabelStore, sequence: str) -> Listed:
    """One of the list; raises NotFoundError when it has neither files nor labels."""
    revision = store.sequences().get(sequence)
    if library.has(sequence):
        found = library.look(sequence)
        return Listed(sequence, revision or 0, found.manifest, found.damaged)
    if revision is None:
        raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
    return Listed(sequence, revision, None, LABELS_ALONE)


def problems_of(library: Library, store: LabelStore, sequence: str) -> list[str]:
    """List faults of a recording's files, its journal or its annotations; [] if sound.

    Raises NotFoundError when it has neither, UnavailableError.
    """
    known, files = sequence in store.sequences(), library.has(sequence)
    if not known and not files:
        raise NotFoundError(f"sequence: expected a known id, got {sequence!r}")
    if not files:
        return [LABELS_ALONE, *_told(lambda: store.check(sequence))]
    damaged = library.look(sequence).damaged
    if known:
        problems = _told(lambda: checking.check_recording(library, store, sequence))
    else:
        problems = _told(lambda: verify(library.store.files(sequence)))
    return problems if damaged is None else [damaged, *problems]


def _told(look: Callable[[], list[str]]) -> list[str]:
    """Return the findings of ``look``; a failure to look is a problem of this one recording."""
    try:
        return look()
    except UnavailableError:
        raise
    except (PointbrushError, OSError, ValueError) as error:
        return [f"cannot be checked: {error}"]
