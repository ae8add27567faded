"""Webhooks of projects, and the durable outbox of events for them.

Changes of tasks enter the outbox in their own transaction.  Edits of labels are in the journal and
jobs in their table: ``gather`` makes events of new rows.  A cursor and deterministic event ids
ensure that each row makes only one event.
"""

from __future__ import annotations

import json
import secrets
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

from sqlalchemy import Connection, Row, and_, delete, func, or_, select, update

from pointbrush.database.database import Database
from pointbrush.database.project_tables import (
    projects,
    webhook_cursors,
    webhook_events,
    webhooks,
)
from pointbrush.database.schema import LIVE, PROJECT_OF, WHOLE, edits, jobs, sequences
from pointbrush.database.statements import insert
from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.values.kinds import time_of
from pointbrush.values.team import webhooks as values
from pointbrush.values.team.webhooks import Topic

TOPICS: tuple[Topic, ...] = get_args(get_args(Topic)[0])
"""Changes of tasks; edits of labels, combined; ended jobs."""
LEASE_SECONDS = 30.0
"""Time for which a server reserves an event that it delivers."""
KEPT_SECONDS = 8 * 86_400.0
"""Time for which events are stored; longer than JOBS_SECONDS, so that no job is announced twice."""
JOBS_SECONDS = 7 * 86_400.0
FIRST_WAIT, LONGEST_WAIT = 5.0, 3600.0
"""First and longest delay of a retry, seconds; it doubles with each attempt."""
FAILED_EVENTS = 3
"""Number of failed events that wait for a retry at which the webhook is paused."""
MOST_WEBHOOKS = 50
"""Limit for a project."""
SHOWN = 100
"""Limit of listed events of a webhook."""
MOST_ATTEMPTS = 30
"""Attempts, over about a day, after which an event is no longer sent; it stays in the list."""
_ENDED = ("done", "failed", "cancelled")


@dataclass(frozen=True, slots=True, kw_only=True)
class Webhook(values.SecretWebhook):
    """A webhook of a project."""

    project: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Delivery(values.Delivery):
    """An event for the ``url`` of a webhook, to be signed with ``secret``."""

    webhook: str
    url: str
    secret: str
    body: str


class Webhooks:
    """The webhooks of one database and their outbox; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, project: str, url: str, topics: Sequence[Topic]) -> Webhook:
        """Add a webhook for events from now on; raises NotFoundError."""
        with self._database.write() as connection:
            # The lock serializes the count among servers.
            there = select(projects.c.id).where(projects.c.id == project).with_for_update()
            if connection.execute(there).first() is None:
                raise NotFoundError(f"project: expected a known id, got {project!r}")
            count = select(func.count()).where(webhooks.c.project == project)
            if connection.execute(count).scalar_one() >= MOST_WEBHOOKS:
                raise BadInputError(f"webhooks: expected at most {MOST_WEBHOOKS} in a project")
            now = self._database.now(connection)
            made = Webhook(
                id=secrets.token_hex(8), project=project, url=url, topics=tuple(topics),
                secret=secrets.token_urlsafe(32), created=time_of(now),
            )  # fmt: skip
            row = {column.name: getattr(made, column.name) for column in webhooks.c}
            new = insert(webhooks, sqlite=self._database.sqlite)
            connection.execute(new.values(row | {"topics": json.dumps(topics), "created": now}))
        return made

    def all(self, project: str | None = None) -> list[Webhook]:
        """Return the webhooks of a project, or of all projects, oldest first."""
        chosen = select(webhooks).order_by(webhooks.c.created)
        if project is not None:
            chosen = chosen.where(webhooks.c.project == project)
        with self._database.read() as connection:
            waiting = connection.execute(_waiting(self._database.now(connection))).all()
            until = {row.webhook: time_of(row.until) for row in waiting}
            rows = connection.execute(chosen).all()
            return [replace(_webhook(row), paused_until=until.get(row.id)) for row in rows]

    def remove(self, project: str, webhook: str) -> None:
        """Delete a webhook with its pending events; raises NotFoundError."""
        with self._database.write() as connection:
            is_webhook = and_(webhooks.c.id == webhook, webhooks.c.project == project)
            if connection.execute(select(webhooks.c.id).where(is_webhook)).first() is None:
                raise NotFoundError(f"webhook: expected one of {project!r}, got {webhook!r}")
            forget_webhooks(connection, is_webhook)

    def deliveries(self, project: str, webhook: str) -> list[Delivery]:
        """Return the newest events of a webhook, newest first."""
        chosen = _events().where(webhooks.c.project == project, webhooks.c.id == webhook)
        with self._database.read() as connection:
            rows = connection.execute(chosen.order_by(webhook_events.c.created.desc()).limit(SHOWN))
            return [_delivery(row) for row in rows]

    # ── gathering of events ──────────────────────────────────────────────────────────────

    def gather(self) -> None:
        """Create events for edits and jobs since the last call of any server."""
        wanted = [each for each in self.all() if {"labels", "job"} & set(each.topics)]
        for webhook in wanted:
            with self._database.write() as connection:
                # The lock keeps other servers from gathering for this webhook.
                row = select(webhooks.c.id).where(webhooks.c.id == webhook.id).with_for_update()
                if connection.execute(row).first() is None:
                    continue
                now = self._database.now(connection)
                if "labels" in webhook.topics:
                    self._gather_edits(connection, webhook, now)
                if "job" in webhook.topics:
                    self._gather_jobs(connection, webhook, now)

    def _gather_edits(self, connection: Connection, webhook: Webhook, now: float) -> None:
        for number, name, before, revision in _moved_on(connection, webhook):
            new = and_(edits.c.sequence == number, edits.c.revision > before)
            rows = connection.execute(
                select(edits.c.revision, edits.c.author, edits.c.points, edits.c.frames).where(
                    new, edits.c.revision <= revision, edits.c.time >= webhook.created.timestamp()
                )
            ).all()
            frames = {frame for row in rows for frame in json.loads(row.frames)}
            body = {
                "sequence": name,
                "from": min((row.revision for row in rows), default=revision) - 1,
                "to": revision,
                "edits": len(rows),
                "points": sum(row.points for row in rows),
                "frames": sorted(frames),
                "people": sorted({row.author for row in rows}),
            }
            key = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{webhook.id} {number} {revision}"))
            if rows:
                self._put(connection, webhook, key, "labels", body, now)
            is_cursor = and_(
                webhook_cursors.c.webhook == webhook.id, webhook_cursors.c.sequence == number
            )
            connection.execute(delete(webhook_cursors).where(is_cursor))
            row = {"webhook": webhook.id, "sequence": number, "revision": revision}
            connection.execute(insert(webhook_cursors, sqlite=self._database.sqlite).values(row))

    def _gather_jobs(self, connection: Connection, webhook: Webhook, now: float) -> None:
        since = max(webhook.created.timestamp(), now - JOBS_SECONDS)
        # The job's recording is the first of its id that was not deleted before the job began.
        held = or_(sequences.c.deleted.is_(None), sequences.c.deleted >= jobs.c.created)
        chosen = (
            select(jobs, PROJECT_OF.label("project"))
            .join(sequences, and_(sequences.c.id == jobs.c.sequence, held), isouter=True)
            .where(jobs.c.state.in_(_ENDED), jobs.c.created >= since)
            .order_by(jobs.c.created, sequences.c.deleted.is_(None), sequences.c.deleted)
        )
        held_by: dict[str, Row[Any]] = {}
        for row in connection.execute(chosen).all():
            held_by.setdefault(row.id, row)
        for row in held_by.values():
            if row.project != webhook.project:
                continue
            body = {name: row._mapping[name] for name in ("id", "kind", "sequence", "state")}
            key = str(uuid.uuid5(uuid.NAMESPACE_OID, f"{webhook.id} {row.id}"))
            self._put(connection, webhook, key, "job", body | {"error": row.error}, now)

    def _put(
        self,
        connection: Connection,
        webhook: Webhook,
        key: str,
        topic: Topic,
        body: Mapping[str, Any],
        now: float,
    ) -> None:
        row = _event_row(webhook.id, webhook.project, key, topic, body, now)
        new = insert(webhook_events, sqlite=self._database.sqlite).values(row)
        connection.execute(new.on_conflict_do_nothing())

    # ── delivery of events ───────────────────────────────────────────────────────────────

    def waiting(self) -> list[str]:
        """Return the ids of webhooks with due events."""
        with self._database.read() as connection:
            due = _due(self._database.now(connection))
            return list(
                connection.execute(select(webhook_events.c.webhook).where(due).distinct()).scalars()
            )

    def take(self, limit: int = 2, webhook: str | None = None) -> list[Delivery]:
        """Reserve due events for this server for ``LEASE_SECONDS``.

        ``webhook``: of one receiver, None: of all.
        """
        with self._database.write() as connection:
            now = self._database.now(connection)
            events = webhook_events.c
            due = _due(now)
            if webhook is not None:
                due = and_(due, events.webhook == webhook)
            free = select(events.id).where(due).order_by(events.due).limit(limit)
            ids = connection.execute(free.with_for_update(skip_locked=True)).scalars().all()
            if not ids:
                return []
            lease = update(webhook_events).where(events.id.in_(ids))
            connection.execute(lease.values(due=now + LEASE_SECONDS, attempts=events.attempts + 1))
            return [
                _delivery(row)
                for row in connection.execute(
                    _events().where(events.id.in_(ids)).order_by(events.created)
                ).all()
            ]

    def note_delivery(self, delivery: Delivery, error: str = "") -> None:
        """Record the delivery of an event, or its error and the time of the retry."""
        is_event = webhook_events.c.id == delivery.id
        with self._database.write() as connection:
            now = self._database.now(connection)
            wait = min(FIRST_WAIT * 2 ** (delivery.attempts - 1), LONGEST_WAIT)
            result = {"error": error, "due": now + wait} if error else {"delivered": now}
            connection.execute(update(webhook_events).where(is_event).values(**result))
            old = webhook_events.c.created < now - KEPT_SECONDS
            connection.execute(delete(webhook_events).where(old))


def announce(connection: Connection, project: str, body: Mapping[str, Any], now: float) -> None:
    """Add a change of a task to the outbox, in the transaction of the change."""
    chosen = select(webhooks).where(webhooks.c.project == project)
    for row in connection.execute(chosen).all():
        if "task" in json.loads(row.topics):
            key = str(uuid.uuid4())
            event = _event_row(row.id, project, key, "task", body, now)
            connection.execute(webhook_events.insert(), event)


def forget_webhooks(connection: Connection, gone: Any) -> None:
    """Delete the webhooks that match ``gone``, with their events."""
    ids = select(webhooks.c.id).where(gone)
    for table in (webhook_cursors, webhook_events):
        connection.execute(delete(table).where(table.c.webhook.in_(ids)))
    connection.execute(delete(webhooks).where(gone))


def _moved_on(connection: Connection, webhook: Webhook) -> list[tuple[int, str, int, int]]:
    """Return number, id, announced and current revision of recordings with new edits."""
    at = and_(
        webhook_cursors.c.webhook == webhook.id, webhook_cursors.c.sequence == sequences.c.number
    )
    chosen = (
        select(
            sequences.c.number,
            sequences.c.id,
            webhook_cursors.c.revision.label("sent"),
            sequences.c.revision,
        )
        .join(webhook_cursors, at, isouter=True)
        .where(LIVE, WHOLE, webhook.project == PROJECT_OF)
        .where(func.coalesce(webhook_cursors.c.revision, 0) < sequences.c.revision)
    )
    rows = connection.execute(chosen).all()
    # Without a cursor, edits from before the webhook are excluded by their time.
    return [(row.number, row.id, row.sent or 0, row.revision) for row in rows]


def _event_row(
    webhook: str, project: str, key: str, topic: Topic, body: Mapping[str, Any], now: float
) -> dict[str, Any]:
    event = {"id": key, "type": topic, "project": project, "time": now, topic: dict(body)}
    return {
        "id": key,
        "webhook": webhook,
        "topic": topic,
        "body": json.dumps(event),
        "created": now,
        "due": now,
        "attempts": 0,
        "error": "",
    }


def _due(now: float) -> Any:
    """Return the condition for events to send, except events of paused webhooks."""
    events = webhook_events.c
    paused = select(_waiting(now).subquery().c.webhook).scalar_subquery()
    return and_(_undelivered(events), events.due <= now, events.webhook.not_in(paused))


def _waiting(now: float) -> Any:
    """Select the paused webhooks and the time of the next attempt.

    A webhook is paused while ``FAILED_EVENTS`` of its events have failed and wait for a retry: a
    single failure may be caused by the event, several mean that the receiver is unreachable.
    """
    events = webhook_events.c
    failed = and_(_undelivered(events), events.error != "", events.due > now)
    chosen = select(events.webhook, func.min(events.due).label("until")).where(failed)
    return chosen.group_by(events.webhook).having(func.count() >= FAILED_EVENTS)


def _undelivered(events: Any) -> Any:
    return and_(events.delivered.is_(None), events.attempts < MOST_ATTEMPTS)


def _events() -> Any:
    columns = [c for c in webhook_events.c if c.name != "due"]
    return select(*columns, webhooks.c.url, webhooks.c.secret).join(
        webhooks, webhooks.c.id == webhook_events.c.webhook
    )


def _webhook(row: Row[Any]) -> Webhook:
    topics = tuple(json.loads(row.topics))
    return Webhook(**{**row._mapping, "topics": topics, "created": time_of(row.created)})


def _delivery(row: Row[Any]) -> Delivery:
    times = {"created": time_of(row.created), "delivered": time_of(row.delivered)}
    return Delivery(**{**row._mapping, **times})
