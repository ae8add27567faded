"""The commands on the workspace of a server: ``--server URL``."""

from __future__ import annotations

import argparse
import shutil
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from pointbrush import arguments, printing
from pointbrush.client import PATIENCE, Classifier, Client, Job
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.following import follow
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.options import chosen
from pointbrush.printing import Answer
from pointbrush.settings import Settings
from pointbrush.work.imports.options import LabelOptions
from pointbrush.work.tracking.options import RunOptions


def client_of(settings: Settings) -> Client:
    """Connect to the server of the settings; raises BadInputError for no URL, or no token."""
    return Client(settings.server, settings.token)


def _followed(client: Client, job: Job) -> dict[str, Any]:
    """Show a job until it has ended, also while the server restarts; return its result."""
    return follow(partial(client.job, patience=PATIENCE), job)


def import_(given: argparse.Namespace, settings: Settings) -> Answer:
    """Upload files and import them as one recording or as several, or preview the import."""
    options = chosen(Corrections, given) | {"name": given.name, "fps": given.fps}
    options |= {"project": given.project}
    with client_of(settings) as client:
        recordings = arguments.imported(given)
        if given.dry_run:
            previews = (client.preview(paths, **options) for paths in recordings)
            return printing.together(map(printing.preview, previews))
        jobs = [client.start_import(paths, **options) for paths in recordings]
        return printing.together(printing.imported(_followed(client, job)) for job in jobs)


def import_labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """Upload and import labels made elsewhere."""
    with client_of(settings) as client:
        recording = client[given.sequence]
        if given.path is None:
            recording.import_source_labels()
            return printing.source_labels_imported(recording.id)
        job = recording.start_label_import(
            [given.path],
            map=None if given.map is None else _text(given.map),
            dry_run=given.dry_run,
            **chosen(LabelOptions, given),
        )
        result = _followed(client, job)
        return printing.labels_imported(result, len(recording.frames), dry_run=given.dry_run)


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise BadInputError(f"--map: expected a readable text file, got {path}: {error}") from None


def track(given: argparse.Namespace, settings: Settings) -> Answer:
    """Track labels."""
    with client_of(settings) as client:
        recording = client[given.sequence]
        labels = arguments.labels_named(given.labels, recording.labels)
        job = recording.start_tracking(labels, given.start, given.stop, **RunOptions.of(given))
        return printing.tracked(_followed(client, job))


def fit_boxes(given: argparse.Namespace, settings: Settings) -> Answer:
    """Fit boxes to labels."""
    with client_of(settings) as client:
        recording = client[given.sequence]
        labels = arguments.labels_named(given.labels, recording.labels)
        job = recording.start_fit_boxes(
            labels, category=given.category, frames=given.frames, redraw=given.redraw
        )
        return printing.fitted(_followed(client, job))


def example(given: argparse.Namespace, settings: Settings) -> Answer:
    """Train, apply, save, load or delete a classifier, or list the classifiers."""
    with client_of(settings) as client:
        known = client.classifiers
        if given.load is not None:
            return printing.classifier(known.load(given.load, given.name))
        if given.sequence is None and given.classifier is None:
            return printing.classifiers(known.all())
        if given.delete:
            known.delete(arguments.required("--classifier", given.classifier))
            return printing.confirmed(f"deleted {given.classifier}", classifier=given.classifier)
        taught = _taught(client, given)
        if given.save is not None:
            known.save(taught.id, given.save)
        if given.apply is None:
            return printing.classifier(taught)
        recording = client[arguments.required("SEQ", given.sequence)]
        frames = "" if given.apply == "all" else given.apply
        job = recording.by_example.start(taught.id, frames, given.above)
        return printing.applied(taught, _followed(client, job))


def _taught(client: Client, given: argparse.Namespace) -> Classifier:
    """Train the given classifier, or a new one."""
    names = [] if given.sequence is None else [client[given.sequence].id]
    if given.classifier is not None:
        return client.classifiers.teach(given.classifier, names)
    classes = None if given.classes is None else arguments.listed(given.classes)
    return client.classifiers.create(
        given.name or given.sequence, names, classes, given.model, given.imported,
        arguments.listed(given.start_from),
    )  # fmt: skip


def export(given: argparse.Namespace, settings: Settings) -> Answer:
    """Export a recording to a .zip or a new folder."""
    out: Path = given.out
    zipped = out.suffix.lower() == ".zip"
    if not zipped and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise BadInputError(f"--out: expected a .zip, or a folder that is new or empty, got {out}")
    with client_of(settings) as client:
        recording = client[given.sequence]
        out.parent.mkdir(parents=True, exist_ok=True)
        known = {entry.format: entry for entry in client.export_formats()}
        snapshot = given.snapshot
        if snapshot:
            versions = client.projects[recording.manifest.project].snapshots()
            snapshot = arguments.snapshot_named(versions, snapshot, recording.id)
        asked = (given.frames, given.val, given.above, snapshot)
        if zipped:
            recording.export(given.format, out, *asked)
        else:
            _unpack(out, lambda target: recording.export(given.format, target, *asked))
        labels, boxes = [] if snapshot else recording.labels(), recording.boxes.all()
        return printing.exported(recording.id, out, known[given.format], labels, boxes)


def token(given: argparse.Namespace, settings: Settings) -> Answer:
    """Add, list or revoke tokens of the server."""
    with client_of(settings) as client:
        if given.action == "list":
            return printing.tokens(
                token for account in client.accounts.all() for token in account.tokens
            )
        name = arguments.required("name", given.name)
        if given.action == "add":
            secret = client.accounts.create(name, given.role, given.days).token
            return printing.confirmed(secret, token=secret)
        for account in client.accounts.all():
            if name in (token.id for token in account.tokens):
                client.accounts.revoke(account.account, name)
                return printing.confirmed(f"revoked {name}", token=name)
        raise NotFoundError(f"token: expected the id of a token, got {name!r}")


def _unpack(out: Path, export: Callable[[Path], Path]) -> None:
    """Unpack an export beside ``out`` and move it there whole."""
    with tempfile.TemporaryDirectory(prefix=f".{out.name}-", dir=out.parent) as name:
        archive = export(Path(name) / "export.zip")
        folder = Path(name) / "unpacked"
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
        if out.exists():
            out.rmdir()
        shutil.move(folder, out)


def info(given: argparse.Namespace, settings: Settings) -> Answer:
    """List the recordings, or describe one."""
    with client_of(settings) as client:
        if given.sequence is None:
            return printing.recordings(
                printing.Row(
                    known.id, known if known.frames else None, known.damaged, known.labels_missing
                )
                for known in client.manifests()
            )
        recording = client[given.sequence]
        return printing.facts(recording.manifest, recording.manifest.revision, recording.labels())


def delete(given: argparse.Namespace, settings: Settings) -> Answer:
    """Delete a recording; ``undelete`` restores it within 30 days."""
    with client_of(settings) as client:
        recording = client[given.sequence]
        recording.delete()
    return printing.deleted(recording.id)


def undelete(given: argparse.Namespace, settings: Settings) -> Answer:
    """Restore a deleted recording."""
    with client_of(settings) as client:
        return printing.undeleted(client.restore(given.sequence).id)


def rename(given: argparse.Namespace, settings: Settings) -> Answer:
    """Rename a recording; its id stays the same."""
    with client_of(settings) as client:
        manifest = client[given.sequence].update(name=given.name)
    return printing.renamed(manifest.id, manifest.name)


def labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """List the labels of a recording with their numbers of points."""
    with client_of(settings) as client:
        return printing.labels(client[given.sequence].labels())


def check_labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """List suspicious labels of a recording."""
    with client_of(settings) as client:
        found = client[given.sequence].review.check(given.frames)
    return printing.findings(found.findings, found.unchecked, settled=given.all, fail=given.fail)


def compare(given: argparse.Namespace, settings: Settings) -> Answer:
    """Compare the labels, or the boxes, of two recordings of the same points."""
    with client_of(settings) as client:
        review = client[given.sequence].review
        other = client[given.other].id
        found = review.agreement(other, frames=given.frames, boxes=given.boxes)
    if found.boxes is not None:
        return printing.boxes_compared(found.boxes.classes, found.boxes.hota)
    return printing.labels_compared(found.labels, found.miou)


def report(given: argparse.Namespace, settings: Settings) -> Answer:
    """Write a report of a recording's labels."""
    arguments.report_suffix(given.out)
    with client_of(settings) as client:
        client[given.sequence].review.report(given.out, given.table)
    return printing.confirmed(f"wrote {given.out}", file=str(given.out))
