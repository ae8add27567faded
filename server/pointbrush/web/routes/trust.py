"""Pages that help a headset trust this server's certificate; they need no token."""

from __future__ import annotations

import io
from html import escape
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, HTMLResponse

from pointbrush.errors import NotFoundError
from pointbrush.web.security.tls import Certificate, fingerprint

router = APIRouter(include_in_schema=False)
PAGES = Path(__file__).parents[1] / "docs"


def certificate_of(request: Request) -> Certificate | None:
    """Return the certificate that the server serves with; None over plain HTTP."""
    certificate: Certificate | None = getattr(request.app.state, "certificate", None)
    return certificate


def authority_of(request: Request) -> Path:
    """Our authority's certificate; raises NotFoundError when we do not serve with one."""
    certificate = certificate_of(request)
    if certificate is None or certificate.authority is None:
        raise NotFoundError("expected a server with a certificate of its own (--tls), got none")
    return certificate.authority


@router.get("/trust", response_class=HTMLResponse)
def explain(request: Request) -> Response:
    """Explain to a headset's user how to trust the server, or how to come to HTTPS first."""
    if certificate_of(request) is None and request.url.scheme == "http":
        text = (PAGES / "plain.html").read_text(encoding="utf-8")
        return HTMLResponse(text.replace("{address}", escape(secure_address(request))))
    text = (PAGES / "trust.html").read_text(encoding="utf-8")
    return HTMLResponse(text.replace("{fingerprint}", fingerprint(authority_of(request))))


def secure_address(request: Request) -> str:
    """Return the page's address over HTTPS, by the name that the request has for the server."""
    return str(request.base_url.replace(scheme="https"))


@router.get("/trust/address.svg")
def address_code(request: Request) -> Response:
    """Return that address as a QR code."""
    import segno

    drawn = io.BytesIO()
    segno.make(secure_address(request), micro=False).save(
        drawn, kind="svg", scale=6, border=4, light="white"
    )
    return Response(drawn.getvalue(), media_type="image/svg+xml")


@router.get("/trust/authority.crt")
def authority(request: Request) -> FileResponse:
    """The authority's certificate; its key stays here."""
    return FileResponse(
        authority_of(request), media_type="application/x-x509-ca-cert", filename="authority.crt"
    )
