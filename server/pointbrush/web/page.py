"""The built page at ``/``, and the exchange of a URL token for the page's cookie."""

from __future__ import annotations

import mimetypes
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, RedirectResponse
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
mimetypes.add_type("text/javascript", ".js")
mimetypes.add_type("application/wasm", ".wasm")


@router.get("/")
def index(request: Request, token: str | None = None) -> Response:
    """The page; a ``token`` in the URL becomes a cookie and leaves the address bar."""
    if token is not None:
        return exchange(request, token)
    if not (PAGE / "index.html").is_file():
        return problem(404, "the page has not been built: run `make page`", "No page")
    headers = {"Cache-Control": "no-cache"}
    return FileResponse(PAGE / "index.html", media_type="text/html", headers=headers)


def exchange(request: Request, token: str) -> Response:
    """Check the token, set the cookie, and redirect to the same URL without it."""
    gate: Gate = request.app.state.gate
    gate.check(token)
    clean = URL(str(request.url)).remove_query_params("token")
    target = "/" + (f"?{clean.query}" if clean.query else "")
    response = RedirectResponse(target, status_code=303)
    set_cookie(request, response, token)
    return response


class Asset(PathConvertor):
    """Any path but the API's: there, an unknown path or method has an answer of its own."""

    regex = r"(?!api/).*"


register_url_convertor("asset", Asset())


@router.get("/{path:asset}")
def static(path: str) -> Response:
    """A file of the built page; nothing outside its folder."""
    file = (PAGE / path).resolve() if "\x00" not in path else PAGE
    if not file.is_relative_to(PAGE.resolve()) or not file.is_file():
        raise NotFoundError(f"path: expected a page or an API route, got /{path[:100]}")
    forever = path.startswith(f"{HASHED}/")
    cache = "public, max-age=31536000, immutable" if forever else "no-cache"
    return FileResponse(file, headers={"Cache-Control": cache})
