"""Health, metrics, sign-in, and the API's own description."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from prometheus_client import CONTENT_TYPE_LATEST, generate_latest

from pointbrush import __version__
from pointbrush.streaming.metrics import Metrics
from pointbrush.streaming.schema import schema_hash
from pointbrush.values.server import Health, Me, NewKeys, OwnKeys, Ready, SignedIn, SignIn
from pointbrush.web.context import Ws
from pointbrush.web.problems import responses
from pointbrush.web.readiness import ReadyProbe
from pointbrush.web.security import auth
from pointbrush.web.security.auth import Caller, Principal, TheGate, resource
from pointbrush.web.security.cookies import set_cookie
from pointbrush.web.security.roles import PREFIX, needs

router = resource("server")
sign_in_router = APIRouter(prefix=PREFIX, tags=["server"])
open_router = APIRouter(include_in_schema=False)
DOCS = Path(__file__).parents[1] / "docs"
DOCS_FILES = {"docs.js": "text/javascript", "docs.css": "text/css"}


def _out(principal: Principal) -> SignedIn:
    return SignedIn(principal.name, principal.role)


@sign_in_router.post("/session", responses=responses(413))
def sign_in(body: SignIn, request: Request, response: Response, gate: TheGate) -> SignedIn:
    """Exchange a token for the page's cookies."""
    auth.require_same_origin(request)
    principal, cookies = gate.sign_in(body.token, request)
    for cookie in cookies:
        set_cookie(request, response, cookie)
    return _out(principal)


@router.get("/session", **needs("viewer"))
def who_am_i(who: Caller) -> SignedIn:
    """Return the identity of the caller."""
    return _out(who)


@router.get("/me", **needs("viewer"))
def me(who: Caller) -> Me:
    """Return the caller's identity, and the hash of the socket's messages."""
    return Me(who.name, who.role, schema_hash(), __version__)


@router.get("/me/keys", **needs("viewer"))
def own_keys(who: Caller, workspace: Ws) -> OwnKeys:
    """Return the keyboard shortcuts that the caller has chosen, in all browsers."""
    return OwnKeys(workspace.labels.own_keys.get(who.author))


@router.put("/me/keys", status_code=204, **needs("viewer", 413))
def set_own_keys(body: NewKeys, who: Caller, workspace: Ws) -> None:
    """Replace the keyboard shortcuts of the caller."""
    workspace.labels.own_keys.put(who.author, body.keys)


@router.delete("/session", status_code=204, **needs("viewer"))
def sign_out(request: Request, response: Response, gate: TheGate) -> None:
    """End the page's session; the browser keeps its account."""
    gate.sign_out(request)
    response.delete_cookie(auth.cookie_name(request), httponly=True, samesite="strict")


@open_router.get("/healthz")
@open_router.get("/api/v1/healthz")
async def healthz() -> Health:
    """Answers while the server is up; needs no token, no worker thread and no database."""
    return Health("ok", __version__)


@open_router.get("/readyz")
@open_router.get("/api/v1/readyz")
async def readyz(request: Request, response: Response) -> Ready:
    """Tell whether work can be done, 200 or 503; needs no token, and names no secret or path."""
    probe: ReadyProbe = request.app.state.ready_probe
    problems = await probe.find_faults()
    parts = {name: problem or "ok" for name, problem in problems.items()}
    if any(problems.values()):
        response.status_code = 503
        response.headers["Retry-After"] = "5"
        return Ready("not ready", parts)
    return Ready("ready", parts)


@open_router.get("/metrics", **needs("viewer"))
@open_router.get("/api/v1/metrics", **needs("viewer"))
def metrics(request: Request, _who: Caller) -> Response:
    """Prometheus text."""
    counters: Metrics = request.app.state.metrics
    return Response(generate_latest(counters.registry), media_type=CONTENT_TYPE_LATEST)


@open_router.get("/api/v1/docs", response_class=HTMLResponse)
def docs() -> FileResponse:
    """The API's description, rendered without anything from elsewhere."""
    return FileResponse(DOCS / "docs.html", media_type="text/html")


@open_router.get("/api/v1/docs/{name}")
def docs_file(name: str) -> Response:
    """The description page's script and style."""
    if name not in DOCS_FILES:
        return Response(status_code=404)
    return FileResponse(DOCS / name, media_type=DOCS_FILES[name])
