"""Webhooks of a project: addresses that receive its events."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from fastapi import Path
from pydantic import Field

from pointbrush.teamwork.webhooks import Topic
from pointbrush.web.auth import resource
from pointbrush.web.context import ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.schemas import Body, Out

router = resource("webhooks")
WebhookId = Annotated[str, Path(pattern="^[0-9a-f]{16}$", description="webhook id")]


class WebhookBody(Body):
    """The address of a webhook; ``topics`` null: all topics."""

    url: Annotated[str, Field(min_length=1, max_length=2000, pattern=r"^https?://[!-~]+$")]
    topics: Annotated[list[Topic], Field(min_length=1, max_length=3)] | None = None


class WebhookOut(Out):
    """A webhook: its address and its topics."""

    id: str
    url: str
    topics: list[Topic]
    created: datetime
    paused_until: Annotated[
        datetime | None, Field(description="time of the next attempt while the receiver is away")
    ] = None


class NewWebhookOut(WebhookOut):
    """A new webhook with the secret that signs its events; no other answer contains the secret."""

    secret: str


class DeliveryOut(Out):
    """An event: time of delivery, number of attempts, and the last error."""

    id: str
    topic: Topic
    created: datetime
    attempts: int
    delivered: datetime | None
    error: str


@router.get("/projects/{p}/webhooks", responses=responses(404))
def list_webhooks(p: ProjectId, workspace: Ws) -> list[WebhookOut]:
    """List the webhooks of a project."""
    return [WebhookOut.of(each) for each in workspace.hooks.all(p)]


@router.post("/projects/{p}/webhooks", status_code=201, responses=responses(404, 413))
def create_webhook(p: ProjectId, body: WebhookBody, workspace: Ws) -> NewWebhookOut:
    """Send future events to an address: changes of tasks, edits (once a minute), ended jobs."""
    return NewWebhookOut.of(workspace.hooks.add(p, body.url, body.topics))


@router.delete("/projects/{p}/webhooks/{w}", status_code=204, responses=responses(404))
def delete_webhook(p: ProjectId, w: WebhookId, workspace: Ws) -> None:
    """Remove a webhook and its undelivered events."""
    workspace.hooks.remove(p, w)


@router.get("/projects/{p}/webhooks/{w}/deliveries", responses=responses(404))
def list_deliveries(p: ProjectId, w: WebhookId, workspace: Ws) -> list[DeliveryOut]:
    """List the latest events of a webhook, the newest first."""
    return [DeliveryOut.of(each) for each in workspace.hooks.deliveries(p, w)]
