"""The commands on a workspace of this machine; each imports its own modules."""

from __future__ import annotations

import argparse
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush import arguments, printing
from pointbrush.accounts.people import expiry_of
from pointbrush.commands.following import follow
from pointbrush.database.integrity import check_database
from pointbrush.errors import (
    BadInputError,
    NotFoundError,
    PointbrushError,
    UnavailableError,
)
from pointbrush.printing import Answer
from pointbrush.settings import Settings, seconds_of
from pointbrush.settings.definitions import chosen, has_password
from pointbrush.system.permissions import open_to_others
from pointbrush.work.backups.backup import DATABASE, move_labels, own_url, restore_backup
from pointbrush.work.backups.series import BackupSeries
from pointbrush.work.imports.options import LabelOptions
from pointbrush.work.palettes import counted_labels
from pointbrush.work.tracking.options import RunOptions
from pointbrush.workspace import Workspace

if TYPE_CHECKING:
    from pointbrush.work.classifiers.service import About

AUTHOR = "command line"
MAKERS = (("demo", None), ("serve", None), ("import", None), ("token", "add"))
"""Commands with their action that make a workspace."""


def _require_workspace(settings: Settings) -> None:
    """Raise NotFoundError if recordings and labels that belong into the folder are not there."""
    recordings = [] if settings.sequences else ["sequences"]
    labels = [] if settings.database else [DATABASE]
    parts = [settings.workspace / name for name in (*recordings, *labels)]
    if parts and not any(part.exists() for part in parts):
        raise NotFoundError(
            f"workspace: expected a folder with a workspace, got {settings.workspace}; --workspace "
            "names another folder, --server a server; `pointbrush import` makes a workspace"
        )


@contextmanager
def _opened(given: argparse.Namespace, settings: Settings) -> Iterator[Workspace]:
    """Open the workspace, and put ids of recordings in the place of names in ``given``.

    Raises NotFoundError where there is no workspace and the command makes none, or no recording of
    a name; BadInputError for a name that several recordings have.
    """
    if (given.command, getattr(given, "action", None)) not in MAKERS:
        _require_workspace(settings)
    with closing(Workspace(settings)) as workspace:
        for name in () if given.command == "undelete" else ("sequence", "other"):
            text = getattr(given, name, None)
            if text is not None and text not in workspace.library.ids():
                setattr(given, name, arguments.recording_named(workspace.listing.all(), text))
        yield workspace


def demo(given: argparse.Namespace, settings: Settings) -> None:
    """Make the sample recording unless there is one, then serve the workspace."""
    from pointbrush.web.server import run

    with _opened(given, settings) as workspace:
        workspace.loops.begin()  # beside the sample, which takes one core
        if not any(
            manifest.source.startswith("sample") for manifest in workspace.library.manifests()
        ):
            job = workspace.imports.begin_sample(frames=given.sample_frames, kind=given.sample)
            follow(workspace.jobs.get, job)
        # Ctrl+C ends a server, after it has drained; that is no failure.
        with suppress(KeyboardInterrupt):
            run(workspace, settings)


def serve(given: argparse.Namespace, settings: Settings) -> None:
    """Serve the workspace until interrupted."""
    from pointbrush.web.server import run

    with _opened(given, settings) as workspace, suppress(KeyboardInterrupt):
        if workspace.read_only:
            print(f"pointbrush: {workspace.read_only}", file=sys.stderr, flush=True)
        run(workspace, settings)


def import_(given: argparse.Namespace, settings: Settings) -> Answer:
    """Import files as one recording or as several, or preview the import."""
    from pointbrush.formats import Limits
    from pointbrush.formats.tables.corrections import Corrections, parse_corrections
    from pointbrush.work.imports.previewing import preview
    from pointbrush.work.imports.requests import ImportRequest

    how = parse_corrections(chosen(Corrections, given))
    recordings, limits = arguments.imported(given), Limits(settings.max_frame_points)
    if given.dry_run:
        wanted = [ImportRequest(tuple(paths), given.name, given.fps, how) for paths in recordings]
        return printing.together(
            printing.preview(asdict(preview(request, limits))) for request in wanted
        )
    options = {"name": given.name, "fps": given.fps, "chosen": how, "project": given.project}
    with _opened(given, settings) as workspace:
        jobs = [workspace.imports.begin(paths, **options) for paths in recordings]
        return printing.together(printing.imported(follow(workspace.jobs.get, job)) for job in jobs)


def import_labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """Import labels made elsewhere."""
    from pointbrush.formats.tables.class_maps import read_map

    with _opened(given, settings) as workspace:
        if given.path is None:
            workspace.imports.bring_labels(given.sequence, AUTHOR)
            return printing.source_labels_imported(given.sequence)
        job = workspace.imports.begin_labels(
            given.sequence,
            given.path,
            AUTHOR,
            names={} if given.map is None else read_map(given.map),
            dry_run=given.dry_run,
            **chosen(LabelOptions, given),
        )
        result = follow(workspace.jobs.get, job)
        frames = len(workspace.recording(given.sequence))
        return printing.labels_imported(result, frames, dry_run=given.dry_run)


def track(given: argparse.Namespace, settings: Settings) -> Answer:
    """Track labels."""
    with _opened(given, settings) as workspace:
        palette = partial(workspace.labels.palette, given.sequence)
        labels = arguments.labels_named(given.labels, palette)
        job = workspace.tracking.start(
            given.sequence,
            start=given.start,
            stop=given.stop,
            labels=labels,
            author=AUTHOR,
            **RunOptions.of(given),
        )
        result = follow(workspace.jobs.get, job)
        return printing.tracked(result)


def fit_boxes(given: argparse.Namespace, settings: Settings) -> Answer:
    """Fit boxes to labels."""
    with _opened(given, settings) as workspace:
        palette = partial(workspace.labels.palette, given.sequence)
        labels = arguments.labels_named(given.labels, palette)
        job = workspace.fitting.fit(
            given.sequence, author=AUTHOR, labels=labels, category=given.category,
            frames=given.frames, redraw=given.redraw,
        )  # fmt: skip
        return printing.fitted(follow(workspace.jobs.get, job))


def example(given: argparse.Namespace, settings: Settings) -> Answer:
    """Train, apply, save, load or delete a classifier, or list the classifiers."""
    with _opened(given, settings) as workspace:
        known = workspace.classifiers
        if given.load is not None:
            return printing.classifier(known.bring(given.load.read_bytes(), given.name))
        if given.sequence is None and given.classifier is None:
            return printing.classifiers(known.listing())
        if given.delete:
            known.delete(arguments.required("--classifier", given.classifier))
            return printing.confirmed(f"deleted {given.classifier}", classifier=given.classifier)
        taught = _taught(workspace, given)
        if given.save is not None:
            given.save.write_bytes(known.file(taught.id))
        if given.apply is None:
            return printing.classifier(taught)
        sequence = arguments.required("SEQ", given.sequence)
        frames = "" if given.apply == "all" else given.apply
        job = workspace.predictions.start(
            sequence, author=AUTHOR, classifier=taught.id, frames=frames, above=given.above
        )
        return printing.applied(taught, follow(workspace.jobs.get, job))


def _taught(workspace: Workspace, given: argparse.Namespace) -> About:
    """Train the given classifier, or a new one."""
    names = [] if given.sequence is None else [given.sequence]
    if given.classifier is not None:
        return workspace.classifiers.teach(given.classifier, names)
    classes = None if given.classes is None else arguments.listed(given.classes)
    return workspace.classifiers.create(
        given.name or given.sequence, names, classes, given.model, given.imported,
        arguments.listed(given.start_from),
    )  # fmt: skip


def export(given: argparse.Namespace, settings: Settings) -> Answer:
    """Export a sequence to a folder or file."""
    with _opened(given, settings) as workspace:
        workspace.recording(given.sequence)
        from pointbrush.formats import EXPORTS  # slow to load

        snapshot = given.snapshot
        if snapshot:
            known = workspace.versions.all(workspace.listing.entry(given.sequence).project)
            snapshot = arguments.snapshot_named(known, snapshot, given.sequence)
        workspace.export(
            given.sequence, given.format, given.out, given.frames, given.val, given.above, snapshot
        )
        counted = [] if snapshot else counted_labels(workspace.labels, given.sequence)
        boxes = workspace.labels.boxes.listing(given.sequence).boxes
        entry = EXPORTS[given.format]
        return printing.exported(given.sequence, given.out, entry, counted, boxes)


def info(given: argparse.Namespace, settings: Settings) -> Answer:
    """List the recordings, or describe one."""
    with _opened(given, settings) as workspace:
        if given.sequence is None:
            return printing.recordings(
                printing.Row(entry.id, entry.manifest, entry.damaged, entry.labels_missing)
                for entry in workspace.listing.all()
            )
        manifest = workspace.recording(given.sequence).manifest
        revision = workspace.labels.revision(manifest.id)
        return printing.facts(manifest, revision, counted_labels(workspace.labels, manifest.id))


def delete(given: argparse.Namespace, settings: Settings) -> Answer:
    """Delete a recording; ``undelete`` restores it within 30 days."""
    with _opened(given, settings) as workspace:
        workspace.recording(given.sequence)
        workspace.deletion.delete(given.sequence)
        return printing.deleted(given.sequence)


def undelete(given: argparse.Namespace, settings: Settings) -> Answer:
    """Restore a deleted recording."""
    with _opened(given, settings) as workspace:
        return printing.undeleted(workspace.deletion.restore(given.sequence))


def rename(given: argparse.Namespace, settings: Settings) -> Answer:
    """Rename a recording; its id stays the same."""
    with _opened(given, settings) as workspace:
        manifest = workspace.update_sequence(given.sequence, name=given.name)
        return printing.renamed(manifest.id, manifest.name)


def labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """List the labels of a recording with their numbers of points."""
    with _opened(given, settings) as workspace:
        return printing.labels(counted_labels(workspace.labels, given.sequence))


def token(given: argparse.Namespace, settings: Settings) -> Answer:
    """Add, list or revoke tokens."""
    with _opened(given, settings) as workspace:
        tokens = workspace.labels.tokens
        if given.action == "list":
            return printing.tokens(tokens.list())
        if not given.name:
            raise BadInputError(f"token {given.action}: expected a name, got none")
        if given.action == "revoke":
            tokens.revoke(given.name)
            return printing.confirmed(f"revoked {given.name}", token=given.name)
        secret = tokens.add(given.role, given.name, expiry_of(given.days))
        return printing.confirmed(secret, token=secret)


def review(given: argparse.Namespace, settings: Settings) -> None:
    """Serve the review panel on loopback until interrupted."""
    from pointbrush.review.panel import ReviewPanel

    with (
        _opened(given, settings) as workspace,
        closing(
            ReviewPanel(
                workspace,
                given.sequence,
                port=given.port,
                explain=given.explain,
                method=given.method,
            )
        ) as panel,
    ):
        print(f"pointbrush review at http://127.0.0.1:{panel.port}/", flush=True)
        threading.Event().wait()


def check(given: argparse.Namespace, settings: Settings) -> Answer:
    """List the faults of the workspace, or repair them; fails if a fault remains."""
    try:
        with _opened(given, settings) as workspace:
            return _checked(given, workspace)
    except UnavailableError:
        for problem in check_database(settings.database_url):
            print(problem)
        raise


def _checked(given: argparse.Namespace, workspace: Workspace) -> Answer:
    wanted = [given.sequence] if given.sequence else [entry.id for entry in workspace.listing.all()]
    rebuilt: list[str] = []
    files = workspace.check_files(repair=given.repair)
    if given.repair:
        repaired = workspace.listing.repair(wanted)
        rebuilt = [f"rebuilt: {line}" for line in repaired.rebuilt]
        rebuilt += [f"removed, to be prepared again: {line}" for line in files.rebuilt]
        problems = [f"cannot be rebuilt: {line}" for line in (*repaired.lost, *files.lost)]
    else:
        problems = workspace.labels.integrity()
        problems += [
            f"{name}: {line}" for name in wanted for line in workspace.listing.problems(name)
        ]
        problems += files.lost
    return printing.checked(
        len(wanted), problems, rebuilt, readable=open_to_others(workspace.settings.workspace)
    )


def check_labels(given: argparse.Namespace, settings: Settings) -> Answer:
    """List suspicious labels of a recording."""
    with _opened(given, settings) as workspace:
        checked = workspace.reviewing.checks(given.sequence, given.frames)
    return printing.findings(
        checked.findings, checked.unchecked, settled=given.all, fail=given.fail
    )


def compare(given: argparse.Namespace, settings: Settings) -> Answer:
    """Compare the labels, or the boxes, of two recordings of the same points."""
    with _opened(given, settings) as workspace:
        pair = given.sequence, given.other
        if given.boxes:
            found = workspace.reviewing.box_agreement(*pair, given.frames)
            return printing.boxes_compared(found.classes, found.hota)
        agreed = workspace.reviewing.agreement(*pair, frames=given.frames)
    return printing.labels_compared(agreed.labels, agreed.miou)


def report(given: argparse.Namespace, settings: Settings) -> Answer:
    """Write a report of a recording's labels."""
    from pointbrush.work.reviewing import to_csv, to_html

    suffix = arguments.report_suffix(given.out)
    with _opened(given, settings) as workspace:
        found = workspace.reviewing.report(given.sequence)
    text = to_html(found) if suffix == ".html" else to_csv(found, given.table)
    given.out.write_text(text, encoding="utf-8")
    return printing.confirmed(f"wrote {given.out}", file=str(given.out))


def headset_report(given: argparse.Namespace, settings: Settings) -> Answer:  # noqa: ARG001
    """Print a report of a headset."""
    from pointbrush.headset_report.model import read_report
    from pointbrush.headset_report.words import report_lines

    found = read_report(given.file)
    return Answer(found, report_lines(found))


def backup(given: argparse.Namespace, settings: Settings) -> Answer:
    """Copy recordings and labels into a new folder, or into the series of ``--backup-to``."""
    if given.target is None and not settings.backup_to:
        raise BadInputError("backup: expected a new folder, or --backup-to with a folder")
    with _opened(given, settings) as workspace:
        if given.target is None:
            series = BackupSeries(Path(settings.backup_to), settings.backup_keep)
            age = None if given.if_older is None else seconds_of("--if-older", given.if_older)
            target = series.add(workspace.back_up, age)
        else:
            workspace.back_up(target := given.target)
    return printing.confirmed(f"backed up to {target}", target=str(target))


def restore(given: argparse.Namespace, settings: Settings) -> Answer:
    """Restore a backup as a new workspace, or one recording of it into this workspace."""
    if given.only:
        with _opened(given, settings) as workspace:
            restored = workspace.restore_from_backup(given.source, given.only)
            return printing.confirmed(f"restored {restored}", sequence=restored)
    if settings.sequences:
        raise BadInputError(
            "restore: expected no --sequences: a backup is restored to a folder; copy the folder's "
            "`sequences` to the bucket afterwards"
        )
    restore_backup(given.source, settings.workspace, settings.database and settings.database_url)
    return printing.confirmed(
        f"restored to {settings.workspace}", workspace=str(settings.workspace)
    )


def move(given: argparse.Namespace, settings: Settings) -> Answer:
    """Move the labels into another database."""
    if has_password(given.target):
        raise BadInputError("move: expected a URL without a password; set PGPASSFILE instead")
    target = own_url(settings.workspace) if given.target == "sqlite" else given.target
    with _opened(given, settings):
        pass  # it can be opened, and its schema is up to date
    move_labels(settings.workspace, settings.database_url, target)
    start = "without --database" if given.target == "sqlite" else f"with --database {target}"
    return printing.confirmed(
        f"moved the labels; start the server {start} from now on", target=target
    )


def bench(given: argparse.Namespace, settings: Settings) -> None:  # noqa: ARG001
    """Run benchmarks/bench_*.py one after the other."""
    folder = Path(__file__).parent.parent.parent / "benchmarks"
    scripts = {path.stem.removeprefix("bench_"): path for path in folder.glob("bench_*.py")}
    if not scripts:
        raise BadInputError("bench: expected to run from a checkout of pointbrush")
    if given.name is not None and given.name not in scripts:
        raise BadInputError(f"bench: expected one of {', '.join(sorted(scripts))}")
    for name in [given.name] if given.name else sorted(scripts):
        print(f"== {name}", flush=True)
        if subprocess.run([sys.executable, scripts[name]], check=False).returncode:
            raise PointbrushError(f"benchmark {name} failed")
