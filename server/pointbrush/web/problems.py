"""Errors as RFC 9457 ``application/problem+json``, with the status of each class of errors."""

from __future__ import annotations

import errno
import logging
import re
from collections.abc import Awaitable, Callable, Mapping
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel, Field
from python_multipart.exceptions import FormParserError
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from pointbrush import errors
from pointbrush.streaming.shared.status import status_of
from pointbrush.system.resources import shortage
from pointbrush.values.validation import describe

logger = logging.getLogger(__name__)

Handler = Callable[[Request, Exception], Awaitable[JSONResponse]]
LONGEST_PATH = 200
"""Characters of a path that are logged, or repeated in an answer."""
CODE = re.compile(r"(/(?:study|participants)/)[^/]+")
MEDIA_TYPE = "application/problem+json"
EXTRA_HEADERS = {
    401: {"WWW-Authenticate": 'Bearer realm="pointbrush"'},
    429: {"Retry-After": "1"},
    503: {"Retry-After": "5"},
}


class Problem(BaseModel):
    """RFC 9457 problem details."""

    type: str = Field(default="about:blank", description="Always ``about:blank``.")
    title: str = Field(description="Kind of error.")
    status: int = Field(ge=400, le=599, description="HTTP status.")
    detail: str = Field(description="Sentence with the expected and the received value.")


def problem(
    status: int,
    detail: str,
    title: str = "",
    headers: Mapping[str, str] | None = None,
    more: Mapping[str, Any] | None = None,
) -> JSONResponse:
    """Return a problem+json response; ``more`` are further members."""
    body = Problem(title=title or HTTPStatus(status).phrase, status=status, detail=detail)
    return JSONResponse(
        {**body.model_dump(), **(more or {})},
        status,
        media_type=MEDIA_TYPE,
        headers={**EXTRA_HEADERS.get(status, {}), **(headers or {})},
    )


def problem_of(
    error: errors.PointbrushError, more: Mapping[str, Any] | None = None
) -> JSONResponse:
    """Return the response for one of our own errors; ``more`` are further members."""
    return problem(status_of(error), str(error), error.title, more=more)


def install(app: FastAPI) -> None:
    """Map every error that can leave a handler."""
    handlers: Mapping[type[Exception], Handler] = {
        errors.PointbrushError: _ours,
        RequestValidationError: _invalid,
        HTTPException: _http,
        FormParserError: _broken_form,
        **dict.fromkeys((OSError, MemoryError, RuntimeError, ImportError), _system),
        Exception: _unexpected,
    }
    for kind, handler in handlers.items():
        app.add_exception_handler(kind, _for_requests(handler))


def loggable(path: str) -> str:
    """Return the begin of a request's path without the code of a study's participant."""
    return CODE.sub(r"\1[hidden]", path)[:LONGEST_PATH]


def _for_requests(handler: Handler) -> Handler:
    """Handle errors of requests only; a socket sends its own messages, and its errors propagate."""

    async def handle(connection: Request, error: Exception) -> JSONResponse:
        if connection.scope["type"] != "http":
            raise error
        return await handler(connection, error)

    return handle


async def _ours(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, errors.PointbrushError)  # noqa: S101 – registered for this class
    if isinstance(error, errors.DamagedError):
        logger.error("%s: %s", loggable(request.url.path), error)
    if error.private:
        logger.warning("%s %s: %s", request.method, loggable(request.url.path), error.whole)
    detail = request.app.state.workspace.paths.hide(str(error))
    return problem(status_of(error), detail, error.title)


async def _broken_form(_request: Request, error: Exception) -> JSONResponse:
    """Refuse an unreadable form, which older versions of Starlette do not."""
    return problem(400, f"form: {error}")


async def _invalid(_request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, RequestValidationError)  # noqa: S101
    found = error.errors()
    malformed = any(item["type"] == "json_invalid" for item in found)
    return problem(400 if malformed else 422, describe(found), errors.BadInputError.title)


async def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)  # noqa: S101
    headers = dict(error.headers or {})
    if error.status_code == 405:
        headers["Allow"] = ", ".join(methods_of(request.app, request.url.path)) or "GET"
    return problem(error.status_code, _error_sentence(request, error, headers), headers=headers)


def _error_sentence(request: Request, error: HTTPException, headers: Mapping[str, str]) -> str:
    """Return a full sentence for errors that the router describes by a phrase."""
    path = loggable(request.url.path)
    if error.status_code == 405:
        return f"method: expected {headers['Allow']} for {path}, got {request.method}"
    if error.status_code == 404 and error.detail == HTTPStatus.NOT_FOUND.phrase:
        return f"path: expected a path of /api/v1/openapi.json, got {path!r}"
    if error.status_code == 400 and isinstance(error.__cause__, RecursionError):
        return "body: expected JSON, got one that is nested too deeply"
    return str(error.detail)


def methods_of(app: FastAPI, path: str) -> list[str]:
    """Return all methods of a path; the router lists only the methods of its first route."""
    found: set[str] = set()
    for template, item in app.openapi()["paths"].items():
        if compile_path(template)[0].fullmatch(path):
            found.update(verb.upper() for verb in item)
    return sorted(found)


async def _system(request: Request, error: Exception) -> JSONResponse:
    if (short := shortage(error)) is not None:
        return problem_of(short)
    if isinstance(error, OSError) and error.errno == errno.EROFS:
        detail = "the workspace's folder is read-only, nothing was changed"
        return problem(403, detail, errors.ReadOnlyError.title)
    return await _unexpected(request, error)


async def _unexpected(request: Request, error: Exception) -> JSONResponse:
    logger.error("%s %s failed", request.method, loggable(request.url.path), exc_info=error)
    return problem(500, "the server failed; its log has the reason")


BINARY = {"schema": {"type": "string", "format": "binary"}}
"""OpenAPI's description of bytes."""


def responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """OpenAPI entries for the problem responses that a route can give."""
    common = (400, 401, 403, 405, 422, 429, 500, 503)
    return {
        status: {
            "description": HTTPStatus(status).phrase,
            "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
        }
        for status in sorted({*common, *statuses})
    }
