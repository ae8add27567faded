"""The built page at ``/``, and the exchange of a URL token for the page's cookie."""

from __future__ import annotations

import mimetypes
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from starlette.convertors import PathConvertor, register_url_convertor
from starlette.datastructures import URL

from pointbrush.errors import NotFoundError
from pointbrush.web.auth import Gate
from pointbrush.web.problems import problem
from pointbrush.web.routes_meta import set_cookie

router = APIRouter(include_in_schema=False)
PAGE = Path(__file__).parent / "page"
HASHED = "assets"
"""Vite puts a hash of the content into these files' names."""
ENCODINGS = {"br": ".br", "gzip": ".gz"}
"""Forms of a text file that the build lays beside it, best first."""
mimetypes.add_type("text/javascript", ".js")
mimetypes.add_type("application/wasm", ".wasm")


@router.get("/")
def index(request: Request, token: str | None = None) -> Response:
    """The page; a ``token`` in the URL becomes a cookie and leaves the address bar."""
    if token is not None:
        return exchange(request, token)
    if not (PAGE / "index.html").is_file():
        return problem(404, "the page has not been built: run `make page`", "No page")
    return _file(request, PAGE / "index.html", "no-cache")


def exchange(request: Request, token: str) -> Response:
    """Check the token, set the cookie, and redirect to the same URL without it."""
    gate: Gate = request.app.state.gate
    _, session = gate.sign_in(token, request)
    clean = URL(str(request.url)).remove_query_params("token")
    target = "/" + (f"?{clean.query}" if clean.query else "")
    response = RedirectResponse(target, status_code=303)
    set_cookie(request, response, session)
    return response


class Asset(PathConvertor):
    """Any path but the API's: there, an unknown path or method has an answer of its own."""

    regex = r"(?!api/).*"


register_url_convertor("asset", Asset())


@router.get("/{path:asset}")
def static(request: Request, path: str) -> Response:
    """A file of the built page; nothing outside its folder."""
    file = (PAGE / path).resolve() if "\x00" not in path else PAGE
    if not file.is_relative_to(PAGE.resolve()) or not file.is_file():
        raise NotFoundError(f"path: expected a page or an API route, got /{path[:100]}")
    forever = path.startswith(f"{HASHED}/")
    cache = "public, max-age=31536000, immutable" if forever else "no-cache"
    return _file(request, file, cache)


def _file(request: Request, file: Path, cache: str) -> Response:
    """A file in the shortest form that the browser reads.

    It is read at once: in pieces, each would wait for a thread of its own.
    """
    headers = {"Cache-Control": cache, "Vary": "Accept-Encoding"}
    accepted = _accepted(request.headers.get("accept-encoding", ""))
    sent = file
    for name, ending in ENCODINGS.items():
        packed = file.with_name(file.name + ending)
        if name in accepted and packed.is_file():
            headers["Content-Encoding"], sent = name, packed
            break
    media_type = mimetypes.guess_type(file.name)[0] or "application/octet-stream"
    return Response(sent.read_bytes(), media_type=media_type, headers=headers)


def _accepted(header: str) -> set[str]:
    """Names in an ``Accept-Encoding`` that are not ruled out by ``q=0``."""
    found = set()
    for item in header.split(","):
        name, _, weight = item.partition(";")
        if weight.replace(" ", "") not in ("q=0", "q=0.0", "q=0.00", "q=0.000"):
            found.add(name.strip().lower())
    return found
