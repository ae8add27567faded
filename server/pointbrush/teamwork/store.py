"""The store of a workspace: its labels, accounts and team, in one database."""

from __future__ import annotations

from pointbrush.accounts.accounts import Accounts, SignIns, Tokens
from pointbrush.accounts.own_keys import OwnKeys
from pointbrush.accounts.people import People
from pointbrush.accounts.signing_keys import SigningKeys
from pointbrush.database.database import Limits
from pointbrush.database.guards import Guards
from pointbrush.database.job_records import JobRecords
from pointbrush.labels.blocks import CACHE_BYTES
from pointbrush.labels.store import LabelStore
from pointbrush.teamwork.headset_reports import HeadsetReports
from pointbrush.teamwork.reviews import Reviews
from pointbrush.teamwork.studies import Studies
from pointbrush.teamwork.team import Team


class WorkspaceStore(LabelStore):
    """The labels of a workspace, and the people who make them; thread-safe."""

    def __init__(
        self, url: str, *, cache_bytes: int = CACHE_BYTES, limits: Limits | None = None
    ) -> None:
        super().__init__(url, cache_bytes=cache_bytes, limits=limits)
        self.tokens = Tokens(self.database)
        self.people = People(self.tokens)
        self.accounts = Accounts(self.database)
        self.sign_ins = SignIns(self.database)
        self.signing_keys = SigningKeys(self.database)
        self.own_keys = OwnKeys(self.database)
        self.headset_reports = HeadsetReports(self.database)
        self.reviews = Reviews(self.database)
        self.studies = Studies(self.database)
        self.team = Team(self.database)
        self.guards = Guards(self.database)
        self.jobs = JobRecords(self.database, self.guards.owner)
        self._open_recordings.listed = self.team.access.forget

    def close(self) -> None:
        """Finish background work and close the connections."""
        self.guards.close()
        super().close()
