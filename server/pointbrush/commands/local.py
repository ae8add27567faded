"""The client's interface, as far as commands use it, for a workspace of this machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush.commands.local_recording import LocalRecording, Part
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.settings import Settings
from pointbrush.values.exports import ExportFormat

if TYPE_CHECKING:
    from pointbrush.database.job import Job
    from pointbrush.values.classifiers import Classifier
    from pointbrush.values.imports import Preview
    from pointbrush.values.kinds import Role
    from pointbrush.values.recordings import Manifest
    from pointbrush.values.team.accounts import NewToken
    from pointbrush.values.team.snapshots import Snapshot
    from pointbrush.work.classifiers.service import Classifiers
    from pointbrush.workspace import Workspace


class LocalClient:
    """The calls of ``client.Client`` on a workspace's folder, which is opened on first use."""

    def __init__(self, settings: Settings, *, makes: bool) -> None:
        """``makes``: make the workspace if there is none."""
        self.settings, self._makes = settings, makes

    @cached_property
    def workspace(self) -> Workspace:
        """The opened workspace; raises NotFoundError if there is none and none is made."""
        from pointbrush.workspace import Workspace

        if not self._makes:
            _require_workspace(self.settings)
        return Workspace(self.settings)

    def close(self) -> None:
        """Close the workspace if it was opened."""
        if "workspace" in vars(self):
            self.workspace.close()

    def id_of(self, text: str) -> str:
        """Return the id of a recording by its id, or else by its name.

        Raises NotFoundError, and BadInputError for a name that several recordings have.
        """
        if text in self.workspace.library.ids():
            return text
        known = self.workspace.listing.all()
        found = [each.id for each in known if each.id == text]
        found = found or [each.id for each in known if each.name == text]
        if not found:
            raise NotFoundError(f"sequence: expected a recording's id or name, got {text!r}")
        if len(found) > 1:
            raise BadInputError(
                f"sequence: expected the name of one recording, got the name of {', '.join(found)}"
            )
        return found[0]

    def __getitem__(self, text: str) -> LocalRecording:
        return LocalRecording(self.workspace, self.id_of(text))

    def manifests(self) -> list[Manifest]:
        return self.workspace.listing.all()

    def restore(self, sequence: str) -> LocalRecording:
        return LocalRecording(self.workspace, self.workspace.deletion.restore(sequence))

    def preview(self, paths: Sequence[Path], **options: Any) -> Preview:
        """Preview an import; opens no workspace."""
        from pointbrush.formats import Limits
        from pointbrush.work.imports.previewing import preview
        from pointbrush.work.imports.requests import ImportRequest

        request = ImportRequest(tuple(paths), **_import_fields(options))
        return preview(request, Limits(self.settings.max_frame_points))

    def start_import(self, paths: Sequence[Path], **options: Any) -> Job:
        return self.workspace.imports.begin(paths, **_import_fields(options))

    def job(self, job: str) -> Job:
        return self.workspace.jobs.get(job)

    def export_formats(self) -> list[ExportFormat]:
        from pointbrush.formats import EXPORTS  # slow to load

        return [ExportFormat.of(each, format=each.name) for each in EXPORTS.values()]

    @property
    def classifiers(self) -> LocalClassifiers:
        return LocalClassifiers(self.workspace.classifiers)

    @property
    def accounts(self) -> LocalAccounts:
        return LocalAccounts(self.workspace)

    @property
    def projects(self) -> LocalProjects:
        return LocalProjects(self.workspace)


def _import_fields(options: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of an ``ImportRequest`` for options of ``Client.start_import``."""
    from pointbrush.formats.tables.corrections import parse_corrections

    own = {name: options.pop(name) for name in ("name", "fps", "project")}
    return own | {"chosen": parse_corrections(options)}


def _require_workspace(settings: Settings) -> None:
    """Raise NotFoundError if recordings and labels that belong into the folder are not there."""
    from pointbrush.work.backups.backup import DATABASE

    recordings = [] if settings.sequences else ["sequences"]
    labels = [] if settings.database else [DATABASE]
    parts = [settings.workspace / name for name in (*recordings, *labels)]
    if parts and not any(part.exists() for part in parts):
        raise NotFoundError(
            f"workspace: expected a folder with a workspace, got {settings.workspace}; --workspace "
            "names another folder, --server a server; `pointbrush import` makes a workspace"
        )


class LocalAccounts:
    """The calls of ``client.Accounts``, with the rights of an admin."""

    def __init__(self, workspace: Workspace) -> None:
        self._people = workspace.labels.people
        self.all = self._people.all

    def create(self, account: str, role: Role, days: float | None) -> NewToken:
        return self._people.create(account, role, days, "admin")

    def revoke(self, account: str, token: str) -> None:
        self._people.revoke(account, token, "admin")


class LocalClassifiers:
    """The calls of ``client.Classifiers``."""

    def __init__(self, service: Classifiers) -> None:
        self._service = service
        self.all, self.create = service.listing, service.create
        self.teach, self.delete = service.teach, service.delete

    def save(self, classifier: str, out: Path) -> None:
        out.write_bytes(self._service.file(classifier))

    def load(self, file: Path, name: str | None) -> Classifier:
        return self._service.import_file(file.read_bytes(), name)


@dataclass(frozen=True, slots=True)
class LocalProjects:
    """The calls of ``client.Projects``."""

    workspace: Workspace

    def __getitem__(self, project: str) -> LocalProject:
        return LocalProject(self.workspace, project)


class LocalProject(Part):
    """The calls of ``client.Project``."""

    def snapshots(self) -> list[Snapshot]:
        return self.workspace.versions.all(self.id)
