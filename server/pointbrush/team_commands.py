"""The commands for the team of a server: projects, tasks, webhooks and undo."""

from __future__ import annotations

import argparse
from dataclasses import replace

from pointbrush import arguments, printing
from pointbrush.errors import BadInputError
from pointbrush.printing import Answer
from pointbrush.remote import client_of
from pointbrush.settings import Settings


def project(given: argparse.Namespace, settings: Settings) -> Answer:
    """List, add or delete projects."""
    with client_of(settings) as client:
        projects = client.projects
        if given.action == "list":
            found = [each.info for each in projects.all()]
            rows = [(each.id, each.role, len(each.recordings), each.name) for each in found]
            return printing.table(found, ("ID", "ROLE", "RECORDINGS", "NAME"), rows)
        name = arguments.required("project", given.name)
        if given.action == "add":
            made = projects.create(name).id
            return printing.confirmed(f"added project {made}", project=made)
        projects[name].delete()
        return printing.confirmed(f"deleted project {name}", project=name)


def task(given: argparse.Namespace, settings: Settings) -> Answer:
    """List, add or delete tasks of a project."""
    with client_of(settings) as client:
        queue, warnings = client.projects[given.project], list[str]()
        if given.action == "delete":
            numbers = [_number(text) for text in given.items]
            arguments.required("task", " ".join(given.items))
            for number in numbers:
                queue.delete_task(number)
            deleted = ", ".join(map(str, numbers))
            return printing.confirmed(f"deleted tasks {deleted}", tasks=numbers)
        if given.action == "add":
            recordings = [client[name].id for name in given.items] or None
            assignee = given.assignee or ""
            known = {each.account for each in client.accounts.all()} if assignee else {assignee}
            if assignee not in known:
                warnings.append(
                    f"no account is called {assignee!r}: `pointbrush token add` creates it"
                )
            found = queue.add_tasks(
                recordings, frames=given.frames, every=given.every, assignee=assignee
            )
        else:
            found = queue.tasks(given.state, given.assignee)
        rows = [
            (each.number, each.sequence, f"{each.first}:{each.last + 1}", each.state, each.assignee)
            for each in found
        ]
        head = ("NUMBER", "RECORDING", "FRAMES", "STATE", "ASSIGNEE")
        return replace(printing.table(found, head, rows), warnings=warnings)


def _number(text: str) -> int:
    if not text.isdecimal():
        raise BadInputError(f"task: expected the number of a task, got {text!r}")
    return int(text)


def webhook(given: argparse.Namespace, settings: Settings) -> Answer:
    """List, add or delete webhooks of a project."""
    with client_of(settings) as client:
        hooks = client.projects[given.project]
        if given.action == "list":
            found = hooks.webhooks()
            rows = [(each["id"], ",".join(each["topics"]), each["url"]) for each in found]
            return printing.table(found, ("ID", "TOPICS", "URL"), rows)
        item = arguments.required("webhook", given.item)
        if given.action == "add":
            topics = arguments.listed(given.topics) if given.topics else None
            made = hooks.add_webhook(item, topics)
            return printing.confirmed(
                f"added webhook {made['id']}, secret {made['secret']}", **made
            )
        hooks.delete_webhook(item)
        return printing.confirmed(f"deleted webhook {item}", webhook=item)


def undo(given: argparse.Namespace, settings: Settings) -> Answer:
    """Undo the caller's last edit of a recording."""
    with client_of(settings) as client:
        recording = client[given.sequence]
        edit = recording.undo()
        line = f"undid your last edit of {recording.id}: {edit.changed:,} points changed"
        return printing.confirmed(line, sequence=recording.id, edit=edit.edit, changed=edit.changed)
