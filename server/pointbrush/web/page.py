"""The built page at ``/`` and ``/check-headset``, and the exchange of a token for its cookie."""

from __future__ import annotations

import mimetypes
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from fastapi import APIRouter, Request, Response
from fastapi.responses import RedirectResponse
from starlette.convertors import PathConvertor, register_url_convertor
from starlette.datastructures import URL

from pointbrush.errors import NotFoundError, TooManyRequestsError, UnauthorizedError
from pointbrush.streaming.shared.status import status_of
from pointbrush.web.problems import EXTRA_HEADERS, problem
from pointbrush.web.security.auth import Gate
from pointbrush.web.security.cookies import set_cookie

router = APIRouter(include_in_schema=False)
PAGE = Path(__file__).parent / "page"
HASHED = "assets"
"""Vite puts a hash of the content into these files' names."""
LONGEST_NAME = 200
"""Most characters of a file's path; some systems raise an error for more than 255."""
ENCODINGS = {"br": ".br", "gzip": ".gz"}
"""Compressed forms of a text file that the build writes, best first."""
mimetypes.add_type("text/javascript", ".js")
mimetypes.add_type("application/wasm", ".wasm")
mimetypes.add_type("model/gltf-binary", ".glb")


@router.get("/")
@router.get("/check-headset")
def index(request: Request, token: str | None = None) -> Response:
    """The page; a ``token`` in the URL becomes a cookie and leaves the address bar.

    The page's script reads from the address whether to check a headset.

    A browser with a wrong token also gets the page, with the status of the refusal: the token stays
    in the address, by which the page reports the error.
    """
    if token is None:
        return document(request)
    try:
        return exchange(request, token)
    except (UnauthorizedError, TooManyRequestsError) as refusal:
        if not (wants_html(request) and built()):
            raise
        status = status_of(refusal)
        return document(request, status, EXTRA_HEADERS[status])


@router.get("/study/{code}")
def study(code: str) -> Response:  # noqa: ARG001 - the page's script reads it from the address
    """The page of a study's participant, whose files are beside this folder."""
    if not built():
        raise NotFoundError("the page has not been built: run `make page`")
    text = (PAGE / "index.html").read_text(encoding="utf-8").replace('"./', '"../')
    return Response(text, media_type="text/html", headers={"Cache-Control": "no-cache"})


def built() -> bool:
    """Return whether the page was built."""
    return (PAGE / "index.html").is_file()


def document(
    request: Request, status: int = 200, more: Mapping[str, str] = MappingProxyType({})
) -> Response:
    """The page's document."""
    if not built():
        return problem(404, "the page has not been built: run `make page`", "No page")
    answer = _file(request, PAGE / "index.html", "no-cache")
    answer.status_code = status
    answer.headers.update(more)
    return answer


def wants_html(request: Request) -> bool:
    """Return whether a browser asks: browsers accept HTML by name, programs accept anything."""
    accepted = request.headers.get("accept", "").split(",")
    return any(item.partition(";")[0].strip() == "text/html" for item in accepted)


def exchange(request: Request, token: str) -> Response:
    """Check the token, set the cookies, and redirect to the same URL without it."""
    gate: Gate = request.app.state.gate
    _, cookies = gate.sign_in(token, request)
    clean = URL(str(request.url)).remove_query_params("token")
    target = clean.path + (f"?{clean.query}" if clean.query else "")
    response = RedirectResponse(target, status_code=303)
    for cookie in cookies:
        set_cookie(request, response, cookie)
    return response


class Asset(PathConvertor):
    """Any path outside the API, which answers an unknown path or method itself."""

    regex = r"(?!api/).*"


register_url_convertor("asset", Asset())


@router.get("/{path:asset}")
def static(request: Request, path: str) -> Response:
    """A file of the built page; nothing outside its folder."""
    known = "\x00" not in path and len(path) <= LONGEST_NAME
    file = (PAGE / path).resolve() if known else PAGE
    if not file.is_relative_to(PAGE.resolve()) or not file.is_file():
        raise NotFoundError(f"path: expected a page or an API route, got /{path[:100]}")
    forever = path.startswith(f"{HASHED}/")
    cache = "public, max-age=31536000, immutable" if forever else "no-cache"
    return _file(request, file, cache)


def _file(request: Request, file: Path, cache: str) -> Response:
    """A file in the shortest form that the browser reads.

    It is read at once: each of several pieces would wait for a thread.
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
