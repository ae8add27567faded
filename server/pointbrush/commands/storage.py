"""The commands on the storage of a workspace: checks, backups, another database."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pointbrush.commands.answers import Answer, confirmed
from pointbrush.commands.arguments import ONE_OR_ALL, argument, switch, verb
from pointbrush.errors import BadInputError, UnavailableError
from pointbrush.settings.definitions import has_password
from pointbrush.settings.settings import seconds_of
from pointbrush.system.permissions import open_to_others

if TYPE_CHECKING:
    from pointbrush.commands.local import LocalClient


@verb(
    ONE_OR_ALL,
    switch(
        "--repair",
        "rebuild indexes, snapshots, counts, palette, tracks and missing checksums, and list the "
        "remaining faults; stop servers first",
    ),
)
def check(given: argparse.Namespace, place: LocalClient) -> Answer:
    """Verify recordings, database, journal and annotations."""
    try:
        return _checked(given, place)
    except UnavailableError:
        from pointbrush.database.integrity import check_database

        for problem in check_database(place.settings.database_url):
            print(problem)
        raise


def _checked(given: argparse.Namespace, place: LocalClient) -> Answer:
    """Check the workspace, or repair it."""
    workspace, rebuilt = place.workspace, list[str]()
    wanted = [entry.id for entry in workspace.listing.all()]
    if given.sequence:
        wanted = [place.id_of(given.sequence)]
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
    return _faults(place.settings.workspace, len(wanted), problems, rebuilt)


def _faults(
    workspace: Path, recordings: int, problems: Sequence[str], rebuilt: Sequence[str]
) -> Answer:
    """List the faults of a workspace; the command fails if there are any."""
    lines = [*rebuilt, *problems]
    if not problems:
        lines.append(f"{recordings} recordings and their labels are sound")
        if open_to_others(workspace):
            lines.append(
                "other users of this machine can read the workspace: chmod -R go= closes it"
            )
    value = {"recordings": recordings, "problems": problems, "rebuilt": rebuilt}
    return Answer(value, lines, error=f"{len(problems)} problems found" if problems else "")


@verb(
    argument(
        "target", "new folder (default: a dated folder in --backup-to)", nargs="?", type=Path
    ),
    argument(
        "--if-older", "do nothing if the newest backup in --backup-to is younger: 90m, 24h or 7d",
        metavar="TIME",
    ),
)  # fmt: skip
def backup(given: argparse.Namespace, place: LocalClient) -> Answer:
    """Copy a workspace, also while it is in use."""
    from pointbrush.work.backups.series import BackupSeries

    target, settings = given.target, place.settings
    if target is None and not settings.backup_to:
        raise BadInputError("backup: expected a new folder, or --backup-to with a folder")
    if target is None:
        workspace = place.workspace
        series = BackupSeries(Path(settings.backup_to), settings.backup_keep)
        age = None if given.if_older is None else seconds_of("--if-older", given.if_older)
        target = series.add(workspace.back_up, age)
    else:
        place.workspace.back_up(target)
    return confirmed(f"backed up to {target}", target=str(target))


@verb(
    argument("source", "folder of a backup", type=Path),
    argument(
        "--only", "restore one recording into an existing workspace, also while it is in use",
        metavar="SEQ",
    ),
)  # fmt: skip
def restore(given: argparse.Namespace, place: LocalClient) -> Answer:
    """Make a workspace from a backup."""
    from pointbrush.work.backups.backup import restore_backup

    if given.only:
        restored = place.workspace.restore_from_backup(given.source, given.only)
        return confirmed(f"restored {restored}", sequence=restored)
    settings = place.settings
    if settings.sequences:
        raise BadInputError(
            "restore: expected no --sequences: a backup is restored to a folder; copy the folder's "
            "`sequences` to the bucket afterwards"
        )
    restore_backup(given.source, settings.workspace, settings.database and settings.database_url)
    return confirmed(f"restored to {settings.workspace}", workspace=str(settings.workspace))


@verb(argument("target", "postgresql://host/name, or 'sqlite': in the workspace", metavar="URL"))
def move(given: argparse.Namespace, place: LocalClient) -> Answer:
    """Move the labels into another database."""
    from pointbrush.work.backups.backup import move_labels, own_url

    if has_password(given.target):
        raise BadInputError("move: expected a URL without a password; set PGPASSFILE instead")
    settings = place.settings
    target = own_url(settings.workspace) if given.target == "sqlite" else given.target
    _ = place.workspace  # it can be opened, and its schema is up to date
    place.close()
    move_labels(settings.workspace, settings.database_url, target)
    start = "without --database" if given.target == "sqlite" else f"with --database {target}"
    return confirmed(f"moved the labels; start the server {start} from now on", target=target)
