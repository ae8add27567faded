"""The FastAPI app: routes by resource, one guard around them, one map of errors."""

from __future__ import annotations

import logging
import secrets
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.concurrency import run_in_threadpool
from fastapi.encoders import jsonable_encoder
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute

from pointbrush import __version__
from pointbrush.settings.settings import Settings, variables
from pointbrush.streaming.hub import Hub
from pointbrush.streaming.metrics import Metrics
from pointbrush.web import page, problems, socket
from pointbrush.web.logs import RequestLog
from pointbrush.web.middleware import Guard
from pointbrush.web.readiness import ReadyProbe
from pointbrush.web.routes import RESOURCES, meta, objects, oidc, studies, trust
from pointbrush.web.routes.export import Exports
from pointbrush.web.security.admissions import Admissions
from pointbrush.web.security.auth import SCHEMES, Gate, requires_caller
from pointbrush.web.security.roles import PREFIX
from pointbrush.web.upload_files import KeptUploads
from pointbrush.web.watching import Watching
from pointbrush.work.backups.series import BackupSchedule, BackupSeries
from pointbrush.work.imports.uploads import Uploads
from pointbrush.work.objects.service import StaleCandidateError
from pointbrush.workspace import Workspace

log = logging.getLogger(__name__)

ROUTERS = (
    *(resource.router for resource in RESOURCES), meta.sign_in_router, socket.router,
    studies.participant_router, meta.open_router, oidc.router, trust.router, page.router,
)  # fmt: skip
"""In the order of matching; the routes of the page match any path."""


def create_app(workspace: Workspace, settings: Settings) -> FastAPI:
    """An app that serves ``workspace``; ``app.state.token`` is the admin token of this run."""
    token = settings.admin_token or secrets.token_urlsafe(24)
    app = FastAPI(
        title="pointbrush",
        version=__version__,
        description="Label point cloud recordings.  Errors are RFC 9457 problem+json.",
        openapi_url=f"{PREFIX}/openapi.json",
        docs_url=None,
        redoc_url=None,
        lifespan=_lifespan,
        redirect_slashes=False,
    )
    app.state.workspace, app.state.token = workspace, token
    app.state.settings = settings
    app.state.gate = Gate(workspace, settings, token)
    app.state.metrics = Metrics()
    app.state.uploads = Uploads(settings.workspace.absolute(), workspace.jobs.uploads)
    app.state.kept_uploads = KeptUploads()
    app.state.backups = _backups(settings, app.state.metrics)
    app.state.exports = Exports(settings.exports, settings.exports_per_person)
    app.state.ready_probe = ReadyProbe(workspace.ready_checks())
    problems.install(app)
    app.add_exception_handler(StaleCandidateError, objects.stale_candidate)
    # Routes that are whole as they stand: `include_router` would build each of them twice again.
    for router in ROUTERS:
        app.router.routes.extend(router.routes)
    app.add_middleware(Guard, settings=settings, gate=app.state.gate, metrics=app.state.metrics)
    app.add_middleware(RequestLog)
    app.openapi = lambda: describe(app)  # type: ignore[method-assign]
    return app


@asynccontextmanager
async def _lifespan(app: FastAPI) -> AsyncIterator[None]:
    uploads: Uploads = app.state.uploads
    uploads.open()
    await run_in_threadpool(app.state.workspace.keep_jobs)
    threading.Thread(target=_import_ahead, name="import-ahead", daemon=True).start()
    backups: BackupSchedule | None = app.state.backups
    if backups is not None:
        backups.begin()
    try:
        async with Hub(app.state.workspace, app.state.metrics).running() as hub:
            app.state.hub = hub
            checked = Admissions(partial(hub.read, socket.admit))
            async with (
                checked.running() as app.state.admissions,
                Watching().running(app.state.workspace) as app.state.watching,
            ):
                yield
    finally:
        if backups is not None:
            await run_in_threadpool(backups.close)
        uploads.close()


def _backups(settings: Settings, metrics: Metrics) -> BackupSchedule | None:
    """Plan the backups that the server is to make, if any; raises BadInputError."""
    if not settings.backup_to:
        return None
    series = BackupSeries(Path(settings.backup_to), settings.backup_keep)
    schedule = BackupSchedule(series, settings.backup_every, variables(settings, "backup"))
    metrics.watch_backups(series.newest_at, lambda: schedule.failures)
    return schedule


def _import_ahead() -> None:
    """Import the libraries of the first stroke while the page is opened."""
    try:
        for name in ("scipy.spatial", "scipy.sparse.csgraph"):
            import_module(name)
    except (OSError, ImportError, MemoryError) as error:  # a shortage: the stroke imports it then
        log.warning("not imported ahead of the first stroke: %s", error)


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the OpenAPI with problem+json instead of FastAPI's error, and the security schemes."""
    if app.openapi_schema:
        return app.openapi_schema
    schema = get_openapi(
        title=app.title, version=app.version, description=app.description, routes=app.routes
    )
    parts = schema["components"]["schemas"]
    for unused in ("HTTPValidationError", "ValidationError"):
        parts.pop(unused, None)
    parts["Problem"] = problems.Problem.model_json_schema()
    schema["components"]["securitySchemes"] = {
        scheme.scheme_name: jsonable_encoder(scheme.model, by_alias=True, exclude_none=True)
        for scheme in SCHEMES
    }
    for route in app.routes:
        if isinstance(route, APIRoute) and route.include_in_schema and requires_caller(route):
            for method in route.methods or ():
                operation = schema["paths"][route.path_format][method.lower()]
                operation["security"] = [{scheme.scheme_name: []} for scheme in SCHEMES]
    app.openapi_schema = schema
    return schema
