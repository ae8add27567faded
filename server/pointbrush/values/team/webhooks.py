"""Webhooks of a project, and the events that they receive."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

from pointbrush.values.base import Body, Meanings, Rule, Value

Topic = Annotated[
    Literal["task", "labels", "job"],
    Meanings(
        {
            "task": "changes of tasks",
            "labels": "edits, at most once a minute for a recording",
            "job": "jobs that have ended",
        }
    ),
]


@dataclass(frozen=True, slots=True)
class NewWebhook(Body):
    """A webhook to add."""

    url: Annotated[str, Rule(min_length=1, max_length=2000, pattern=r"^https?://[!-~]+$")]
    """Address that receives the events."""
    topics: Annotated[tuple[Topic, ...], Rule(min_length=1, max_length=3)] | None = None
    """Events to send; null: all."""


@dataclass(frozen=True, slots=True)
class Webhook(Value):
    """An address that receives events."""

    id: str
    """Id in URLs."""
    url: str
    """Address that receives the events."""
    topics: tuple[Topic, ...]
    """Events that are sent."""
    created: datetime
    """Time of its creation."""
    paused_until: datetime | None = None
    """Time of the next attempt while the receiver is away; null: it answers."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SecretWebhook(Webhook):
    """A new webhook; no other answer contains the secret."""

    secret: str
    """Secret that signs its events."""


@dataclass(frozen=True, slots=True)
class Delivery(Value):
    """An event and its delivery."""

    id: str
    """Id of the event, which a receiver may use to drop repetitions."""
    topic: Topic
    """Kind of the event."""
    created: datetime
    """Time of the event."""
    attempts: int
    """Number of attempts to deliver it."""
    delivered: datetime | None
    """Time of its delivery; null: not yet."""
    error: str
    """Reason of the last failure, or empty."""
