"""Pages by which a headset comes to trust this server's certificate; need no token."""

from __future__ import annotations

from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, HTMLResponse

from pointbrush.errors import NotFoundError
from pointbrush.web.tls import Certificate

router = APIRouter(include_in_schema=False)
PAGE = Path(__file__).parents[1] / "docs" / "trust.html"


def authority_of(request: Request) -> Path:
    """Our authority's certificate; raises NotFoundError when we do not serve with one."""
    certificate: Certificate | None = getattr(request.app.state, "certificate", None)
    if certificate is None or certificate.authority is None:
        raise NotFoundError("expected a server with a certificate of its own (--tls), got none")
    return certificate.authority


def fingerprint(authority: Path) -> str:
    """SHA-256 of a certificate, in pairs of digits as browsers show it."""
    found = x509.load_pem_x509_certificate(authority.read_bytes())
    return found.fingerprint(hashes.SHA256()).hex(":").upper()


@router.get("/trust", response_class=HTMLResponse)
def explain(request: Request) -> Response:
    """The page for whoever wears the headset."""
    text = PAGE.read_text(encoding="utf-8")
    return HTMLResponse(text.replace("{fingerprint}", fingerprint(authority_of(request))))


@router.get("/trust/authority.crt")
def authority(request: Request) -> FileResponse:
    """The authority's certificate; its key stays here."""
    return FileResponse(
        authority_of(request), media_type="application/x-x509-ca-cert", filename="authority.crt"
    )
