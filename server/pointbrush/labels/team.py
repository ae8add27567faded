"""Parts of a label database for teams: projects, their queues, roles and copies."""

from __future__ import annotations

from pointbrush.labels.access import Access
from pointbrush.labels.copies import Copies
from pointbrush.labels.database import Database
from pointbrush.labels.projects import Projects
from pointbrush.labels.sessions import Sessions
from pointbrush.labels.summaries import Summaries
from pointbrush.labels.tasks import Tasks
from pointbrush.labels.versions import Moment, PastLabels, Versions
from pointbrush.labels.webhooks import Webhooks


class Team:
    """Projects, their tasks and versions; thread-safe."""

    def __init__(self, database: Database, sessions: Sessions) -> None:
        self._sessions = sessions
        self.projects, self.tasks = Projects(database), Tasks(database)
        self.versions, self.summaries = Versions(database), Summaries(database)
        self.webhooks = Webhooks(database)
        self.access, self.copies = Access(database), Copies(database)
        sessions.listed = self.access.forget

    def at(self, moment: Moment) -> PastLabels:
        """Return the labels of a recording as they were at a moment."""
        return PastLabels(self._sessions, moment)
