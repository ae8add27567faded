"""Webhooks of a project: addresses that receive its events."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path

from pointbrush.values.team.webhooks import Delivery, NewWebhook, SecretWebhook, Webhook
from pointbrush.web.context import ProjectId, Ws
from pointbrush.web.security.auth import resource
from pointbrush.web.security.roles import needs

router = resource("webhooks")
WebhookId = Annotated[str, Path(pattern="^[0-9a-f]{16}$", description="webhook id")]


@router.get("/projects/{p}/webhooks", **needs("manager", 404))
def list_webhooks(p: ProjectId, workspace: Ws) -> list[Webhook]:
    """List the webhooks of a project."""
    return [*workspace.hooks.all(p)]


@router.post("/projects/{p}/webhooks", status_code=201, **needs("manager", 404, 413))
def create_webhook(p: ProjectId, body: NewWebhook, workspace: Ws) -> SecretWebhook:
    """Send future events to an address: changes of tasks, edits (once a minute), ended jobs."""
    return workspace.hooks.add(p, body.url, body.topics)


@router.delete("/projects/{p}/webhooks/{w}", status_code=204, **needs("manager", 404))
def delete_webhook(p: ProjectId, w: WebhookId, workspace: Ws) -> None:
    """Remove a webhook and its undelivered events."""
    workspace.hooks.remove(p, w)


@router.get("/projects/{p}/webhooks/{w}/deliveries", **needs("manager", 404))
def list_deliveries(p: ProjectId, w: WebhookId, workspace: Ws) -> list[Delivery]:
    """List the latest events of a webhook, the newest first."""
    return [*workspace.hooks.deliveries(p, w)]
