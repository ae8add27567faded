"""Webhooks of a project: addresses that receive its events."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Path

from pointbrush.teamwork import webhooks
from pointbrush.values.kinds import time_of
from pointbrush.values.team.webhooks import Delivery, NewWebhook, SecretWebhook, Webhook
from pointbrush.web.context import ProjectId, Ws
from pointbrush.web.problems import responses
from pointbrush.web.security.auth import resource

router = resource("webhooks")
WebhookId = Annotated[str, Path(pattern="^[0-9a-f]{16}$", description="webhook id")]


@router.get("/projects/{p}/webhooks", responses=responses(404))
def list_webhooks(p: ProjectId, workspace: Ws) -> list[Webhook]:
    """List the webhooks of a project."""
    return [Webhook.of(each, **_times(each)) for each in workspace.hooks.all(p)]


@router.post("/projects/{p}/webhooks", status_code=201, responses=responses(404, 413))
def create_webhook(p: ProjectId, body: NewWebhook, workspace: Ws) -> SecretWebhook:
    """Send future events to an address: changes of tasks, edits (once a minute), ended jobs."""
    made = workspace.hooks.add(p, body.url, body.topics)
    return SecretWebhook.of(made, **_times(made))


@router.delete("/projects/{p}/webhooks/{w}", status_code=204, responses=responses(404))
def delete_webhook(p: ProjectId, w: WebhookId, workspace: Ws) -> None:
    """Remove a webhook and its undelivered events."""
    workspace.hooks.remove(p, w)


@router.get("/projects/{p}/webhooks/{w}/deliveries", responses=responses(404))
def list_deliveries(p: ProjectId, w: WebhookId, workspace: Ws) -> list[Delivery]:
    """List the latest events of a webhook, the newest first."""
    return [
        Delivery.of(each, created=time_of(each.created), delivered=time_of(each.delivered))
        for each in workspace.hooks.deliveries(p, w)
    ]


def _times(found: webhooks.Webhook) -> dict[str, Any]:
    return {"created": time_of(found.created), "paused_until": time_of(found.paused_until)}
