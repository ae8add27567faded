"""Parts of a label database that lead people: projects, their queues, who may see what."""

from __future__ import annotations

from pointbrush.labels.access import Access
from pointbrush.labels.database import Database
from pointbrush.labels.projects import Projects
from pointbrush.labels.tasks import Tasks


class Team:
    """Projects and their tasks; thread-safe."""

    def __init__(self, database: Database) -> None:
        self.projects, self.tasks = Projects(database), Tasks(database)
        self.access = Access(database)
