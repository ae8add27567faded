"""The commands for a team: projects, tasks, webhooks and tokens."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from pointbrush.accounts.roles import ROLES
from pointbrush.commands.answers import Answer, confirmed, table
from pointbrush.commands.arguments import (
    FROM_ONE,
    PROJECT,
    argument,
    listed,
    positive,
    required,
    verb,
)
from pointbrush.commands.places import Place
from pointbrush.errors import BadInputError, NotFoundError

if TYPE_CHECKING:
    from pointbrush.client import Client

ACTION = argument("action", "the action", choices=("list", "add", "delete"))


@verb(ACTION, argument("name", "name of a new project (add), or its id (delete)", nargs="?"))
def project(given: argparse.Namespace, client: Client) -> Answer:
    """List, add or delete projects of a server."""
    projects = client.projects
    if given.action == "list":
        infos = [each.info for each in projects.all()]
        rows = [(each.id, each.role, len(each.recordings), each.name) for each in infos]
        return table(infos, ("ID", "ROLE", "RECORDINGS", "NAME"), rows)
    name = required("project", given.name)
    if given.action == "add":
        made = projects.create(name).id
        return confirmed(f"added project {made}", project=made)
    projects[name].delete()
    return confirmed(f"deleted project {name}", project=name)


@verb(
    ACTION,
    argument(
        "items", "recordings (add; default: all of the project), or numbers of tasks (delete)",
        nargs="*", metavar="ITEM",
    ),
    argument("--state", "only tasks in this state (list)"),
    argument("--assignee", "account of the assignee (list, add)"),
    argument("--frames", "frames of the tasks (add; default: all)", metavar="I:J"),
    argument("--every", "frames of a task (add)", type=FROM_ONE, metavar="N"),
    PROJECT,
)  # fmt: skip
def task(given: argparse.Namespace, client: Client) -> Answer:
    """List, add or delete labelling tasks of a server."""
    queue, warnings = client.projects[given.project], list[str]()
    if given.action == "delete":
        numbers = [_number(text) for text in given.items]
        required("task", " ".join(given.items))
        for number in numbers:
            queue.delete_task(number)
        deleted = ", ".join(map(str, numbers))
        return confirmed(f"deleted tasks {deleted}", tasks=numbers)
    if given.action == "add":
        recordings = [client[name].id for name in given.items] or None
        assignee = given.assignee or ""
        known = {each.account for each in client.accounts.all()} if assignee else {assignee}
        if assignee not in known:
            warnings.append(f"no account is called {assignee!r}: `pointbrush token add` creates it")
        tasks = queue.add_tasks(
            recordings, frames=given.frames, every=given.every, assignee=assignee
        )
    else:
        tasks = queue.tasks(given.state, given.assignee)
    rows = [
        (each.number, each.sequence, f"{each.first}:{each.last + 1}", each.state, each.assignee)
        for each in tasks
    ]
    head = ("NUMBER", "RECORDING", "FRAMES", "STATE", "ASSIGNEE")
    return replace(table(tasks, head, rows), warnings=warnings)


def _number(text: str) -> int:
    if not text.isdecimal():
        raise BadInputError(f"task: expected the number of a task, got {text!r}")
    return int(text)


@verb(
    ACTION,
    argument("item", "URL to call (add), or the webhook's id (delete)", nargs="?"),
    argument("--topics", "task, labels or job, separated by commas (add; default: all)"),
    PROJECT,
)
def webhook(given: argparse.Namespace, client: Client) -> Answer:
    """List, add or delete webhooks of a server."""
    hooks = client.projects[given.project]
    if given.action == "list":
        known = hooks.webhooks()
        rows = [(each.id, ",".join(each.topics), each.url) for each in known]
        return table(known, ("ID", "TOPICS", "URL"), rows)
    item = required("webhook", given.item)
    if given.action == "add":
        topics: Any = listed(given.topics) if given.topics else None
        made = hooks.add_webhook(item, topics)
        return confirmed(f"added webhook {made.id}, secret {made.secret}", **asdict(made))
    hooks.delete_webhook(item)
    return confirmed(f"deleted webhook {item}", webhook=item)


@verb(
    argument("action", "the action", choices=("add", "list", "revoke")),
    argument("name", "name of the person (add), or the token's id", nargs="?"),
    argument("--role", f"one of {', '.join(ROLES)}", default="annotator"),
    argument("--days", "days until the token expires", type=positive),
)
def token(given: argparse.Namespace, place: Place) -> Answer:
    """Add, list or revoke access tokens."""
    if given.action == "list":
        return _tokens(place)
    name = required("name", given.name)
    if given.action == "add":
        secret = place.accounts.create(name, given.role, given.days).token
        return confirmed(secret, token=secret)
    for account in place.accounts.all():
        if name in (token.id for token in account.tokens):
            place.accounts.revoke(account.account, name)
            return confirmed(f"revoked {name}", token=name)
    raise NotFoundError(f"token: expected the id of a token, got {name!r}")


def _tokens(place: Place) -> Answer:
    """List tokens, without their secrets."""
    rows = [
        {
            "id": each.id,
            "role": each.role,
            "name": each.name,
            "status": "valid" if each.valid else "revoked" if each.revoked else "expired",
        }
        for account in place.accounts.all()
        for each in account.tokens
    ]
    if not rows:
        return Answer(rows, ["no tokens; `pointbrush token add NAME --role annotator` adds one"])
    return table(rows, ("ID", "ROLE", "NAME", "STATUS"), [list(row.values()) for row in rows])
