"""The role that each call needs: a route that is not in this table is nobody's.

``docs/roles.md`` shows it; tests compare the two, and the table with the app's routes.
"""

from __future__ import annotations

from collections.abc import Mapping

from pointbrush.roles import Role

PREFIX = "/api/v1"

OPEN = frozenset({
    ("POST", "/session"),
    ("GET", "/oidc"),
    ("GET", "/oidc/login"),
    ("GET", "/oidc/callback"),
    ("GET", "/healthz"),
    ("GET", "/readyz"),
    ("GET", "/docs"),
    ("GET", "/docs/{name}"),
    ("GET", "/openapi.json"),
    ("GET", "/trust"),
    ("GET", "/trust/address.svg"),
    ("GET", "/trust/authority.crt"),
    ("GET", "/"),
    ("GET", "/check-headset"),
    ("GET", "/{path:asset}"),
})  # fmt: skip
"""Calls that need no token: signing in, and what is no secret."""

ROUTES: Mapping[tuple[str, str], Role] = {
    ("GET", "/session"): "viewer",
    ("DELETE", "/session"): "viewer",
    ("GET", "/me"): "viewer",
    ("GET", "/metrics"): "viewer",
    ("GET", "/sequences"): "viewer",
    ("GET", "/sequences/{seq}"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/points"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/thumbnail"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/annotation"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/chunks"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/chunks/{c}"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/cameras"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/placements"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/images/{camera}"): "viewer",
    ("GET", "/sequences/{seq}/labels"): "viewer",
    ("GET", "/sequences/{seq}/labels/{id}"): "viewer",
    ("GET", "/sequences/{seq}/boxes"): "viewer",
    ("GET", "/sequences/{seq}/boxes/{id}"): "viewer",
    ("GET", "/sequences/{seq}/edits"): "viewer",
    ("GET", "/sequences/{seq}/palette"): "viewer",
    ("GET", "/sequences/{seq}/categories"): "viewer",
    ("GET", "/templates"): "viewer",
    ("GET", "/sequences/{seq}/tracks"): "viewer",
    ("GET", "/sequences/{seq}/export"): "viewer",
    ("GET", "/sequences/{seq}/review"): "viewer",
    ("GET", "/sequences/{seq}/review/history"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/review"): "viewer",
    ("GET", "/sequences/{seq}/checks"): "viewer",
    ("GET", "/sequences/{seq}/agreement"): "viewer",
    ("GET", "/sequences/{seq}/report"): "viewer",
    ("GET", "/sequences/{seq}/frames/{i}/agreement"): "viewer",
    ("GET", "/taxonomy"): "viewer",
    ("GET", "/projects"): "viewer",
    ("GET", "/projects/{p}"): "viewer",
    ("GET", "/projects/{p}/statistics"): "viewer",
    ("GET", "/projects/{p}/tasks"): "viewer",
    ("GET", "/projects/{p}/snapshots"): "viewer",
    ("GET", "/projects/{p}/snapshots/{s}"): "viewer",
    ("GET", "/projects/{p}/snapshots/{s}/difference"): "viewer",
    ("GET", "/projects/{p}/tasks/{t}"): "viewer",
    ("GET", "/projects/{p}/tasks/{t}/history"): "viewer",
    ("GET", "/exports"): "viewer",
    ("GET", "/classifiers"): "viewer",
    ("GET", "/classifiers/{id}"): "viewer",
    ("GET", "/classifiers/{id}/file"): "viewer",
    ("GET", "/sequences/{seq}/events"): "viewer",
    ("GET", "/jobs"): "viewer",
    ("GET", "/jobs/{id}"): "viewer",
    ("WEBSOCKET", "/stream"): "viewer",
    ("PUT", "/sequences/{seq}/frames/{i}/annotation"): "annotator",
    ("POST", "/sequences/{seq}/frames/{i}/strokes"): "annotator",
    ("POST", "/sequences/{seq}/frames/{i}/object"): "annotator",
    ("POST", "/sequences/{seq}/annotations"): "annotator",
    ("PUT", "/sequences/{seq}/annotations"): "annotator",
    ("POST", "/sequences/{seq}/source-labels"): "annotator",
    ("POST", "/sequences/{seq}/undo"): "annotator",
    ("POST", "/sequences/{seq}/redo"): "annotator",
    ("POST", "/sequences/{seq}/labels"): "annotator",
    ("POST", "/sequences/{seq}/palette"): "annotator",
    ("PUT", "/sequences/{seq}/palette/order"): "annotator",
    ("PATCH", "/sequences/{seq}/labels/{id}"): "annotator",
    ("DELETE", "/sequences/{seq}/labels/{id}"): "annotator",
    ("POST", "/sequences/{seq}/labels/{id}/merge"): "annotator",
    ("POST", "/sequences/{seq}/labels/{id}/split"): "annotator",
    ("POST", "/sequences/{seq}/boxes"): "annotator",
    ("POST", "/sequences/{seq}/boxes/fit"): "annotator",
    ("PATCH", "/sequences/{seq}/boxes/{id}"): "annotator",
    ("DELETE", "/sequences/{seq}/boxes/{id}"): "annotator",
    ("POST", "/sequences/{seq}/boxes/{id}/points"): "annotator",
    ("POST", "/sequences/{seq}/floor"): "annotator",
    ("DELETE", "/sequences/{seq}/floor"): "annotator",
    ("POST", "/sequences/{seq}/tracking"): "annotator",
    ("POST", "/classifiers"): "annotator",
    ("POST", "/classifiers/{id}/teach"): "annotator",
    ("POST", "/sequences/{seq}/frames/{i}/prediction"): "annotator",
    ("GET", "/sequences/{seq}/doubt"): "annotator",
    ("POST", "/sequences/{seq}/predictions"): "annotator",
    ("DELETE", "/sequences/{seq}/features"): "annotator",
    ("POST", "/sequences/{seq}/clear"): "annotator",
    ("PUT", "/sequences/{seq}/review"): "annotator",
    ("PUT", "/sequences/{seq}/frames/{i}/review"): "annotator",
    ("DELETE", "/jobs/{id}"): "annotator",
    ("POST", "/projects/{p}/tasks/next"): "annotator",
    ("PATCH", "/projects/{p}/tasks/{t}"): "annotator",
    ("POST", "/sequences/{seq}/frames/{i}/accept"): "reviewer",
    ("POST", "/sequences/{seq}/frames/{i}/copy"): "annotator",
    ("POST", "/sequences/{seq}/frames/{i}/clear"): "annotator",
    ("POST", "/sequences/{seq}/accept"): "reviewer",
    ("GET", "/projects/{p}/agreement"): "reviewer",
    ("POST", "/projects/{p}/merge"): "reviewer",
    ("GET", "/projects/{p}/scores"): "reviewer",
    ("POST", "/classifiers/file"): "manager",
    ("DELETE", "/classifiers/{id}"): "manager",
    ("PUT", "/taxonomy"): "manager",
    ("POST", "/projects"): "manager",
    ("PATCH", "/projects/{p}"): "manager",
    ("DELETE", "/projects/{p}"): "manager",
    ("POST", "/projects/{p}/tasks"): "manager",
    ("POST", "/projects/{p}/imports"): "manager",
    ("POST", "/projects/{p}/snapshots"): "manager",
    ("GET", "/projects/{p}/webhooks"): "manager",
    ("POST", "/projects/{p}/webhooks"): "manager",
    ("DELETE", "/projects/{p}/webhooks/{w}"): "manager",
    ("GET", "/projects/{p}/webhooks/{w}/deliveries"): "manager",
    ("DELETE", "/projects/{p}/snapshots/{s}"): "manager",
    ("DELETE", "/projects/{p}/tasks/{t}"): "manager",
    ("POST", "/sequences"): "manager",
    ("POST", "/imports/preview"): "manager",
    ("DELETE", "/imports/{upload}"): "manager",
    ("PATCH", "/sequences/{seq}"): "manager",
    ("DELETE", "/sequences/{seq}"): "manager",
    ("POST", "/sequences/{seq}/restore"): "manager",
}

DECIDE: Role = "reviewer"
"""Role that may accept and reject frames, and take back that they were accepted."""
ASSIGN: Role = "manager"
"""Role that may give frames to people."""
CANCEL_ANY: Role = "manager"
"""Role that may cancel jobs that somebody else has started."""


def call_of(method: str, path: str) -> tuple[str, str]:
    """A route's place in the table; ``path`` is its template."""
    return method, path.removeprefix(PREFIX)
