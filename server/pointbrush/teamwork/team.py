"""Parts of a workspace's database for teams: projects, their queues, roles and copies."""

from __future__ import annotations

from pointbrush.database.database import Database
from pointbrush.teamwork.access import Access
from pointbrush.teamwork.copies import Copies
from pointbrush.teamwork.projects import Projects
from pointbrush.teamwork.summaries import Summaries
from pointbrush.teamwork.tasks import Tasks
from pointbrush.teamwork.webhooks import Webhooks


class Team:
    """Projects, their tasks and webhooks; thread-safe."""

    def __init__(self, database: Database) -> None:
        self.projects, self.tasks = Projects(database), Tasks(database)
        self.summaries, self.webhooks = Summaries(database), Webhooks(database)
        self.access, self.copies = Access(database), Copies(database)
