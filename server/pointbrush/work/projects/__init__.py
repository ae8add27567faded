"""Projects: recordings in groups, their people, and the queue of who labels what next."""

from __future__ import annotations

from pointbrush.work.projects.agreeing import Agreeing
from pointbrush.work.projects.delivering import Hooks
from pointbrush.work.projects.queue import NewTasks, Queue, Wish
from pointbrush.work.projects.service import Overview, Projects
from pointbrush.work.projects.versions import Versions

__all__ = ["Agreeing", "Hooks", "NewTasks", "Overview", "Projects", "Queue", "Versions", "Wish"]
