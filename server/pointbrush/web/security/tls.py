"""HTTPS for headsets on the local network: a certificate authority, created once and kept.

WebXR needs a secure context.  A headset trusts the authority once; certificates for this machine's
names are renewed under it without another confirmation.  Most servers have none: the library for
certificates is imported on first use.
"""

from __future__ import annotations

import datetime
import os
import socket
from dataclasses import dataclass
from pathlib import Path

from pointbrush.errors import BadInputError, ReadOnlyError
from pointbrush.settings import Settings
from pointbrush.system.permissions import writable

CERTIFICATE_DAYS = 90
RENEW_DAYS = 14


@dataclass(frozen=True)
class Certificate:
    """Files for HTTPS; ``authority``: the file that a headset installs, if pointbrush made it."""

    certfile: Path
    keyfile: Path
    authority: Path | None = None


def certificate(settings: Settings) -> Certificate | None:
    """Return the certificate to serve with, or None for plain HTTP.

    Raises BadInputError if a given file does not exist, or if only one of both is given.
    """
    if settings.certfile or settings.keyfile:
        return _given(settings)
    if not settings.tls:
        return None
    folder = settings.workspace.absolute() / "tls"
    kept = Certificate(folder / "server.pem", folder / "server.key", folder / "authority.pem")
    names = machine_names(settings)
    if not _usable(kept.certfile, names):
        if not writable(folder if folder.is_dir() else folder.parent):
            raise ReadOnlyError(
                f"tls: expected a folder to keep a certificate in, {folder} is read-only; give "
                "one by --certfile and --keyfile"
            )
        _issue(folder, names)
    return kept


def _given(settings: Settings) -> Certificate:
    if not (settings.certfile and settings.keyfile):
        raise BadInputError("expected both --certfile and --keyfile, got one of them")
    files = Path(settings.certfile), Path(settings.keyfile)
    for file in files:
        if not file.is_file():
            raise BadInputError(f"expected a PEM file, {file} does not exist")
    return Certificate(*files)


def machine_names(settings: Settings) -> list[str]:
    """Return the names and addresses of this machine on its network."""
    name = socket.gethostname()
    names = {"localhost", "127.0.0.1", "::1", name, f"{name.split('.')[0]}.local"}
    names.update(host.strip() for host in settings.allowed_hosts.split(","))
    if settings.host not in ("0.0.0.0", "::"):  # noqa: S104 – compared, not bound
        names.add(settings.host)
    try:
        found = socket.getaddrinfo(name, None)
    except OSError:
        found = []
    names.update(str(entry[4][0]).split("%")[0] for entry in found)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
            names.add(probe.getsockname()[0])
        except OSError:
            pass  # no network: no further names
    return sorted(names - {""})


def fingerprint(authority: Path) -> str:
    """SHA-256 of a certificate, in pairs of digits as browsers show it."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes

    found = x509.load_pem_x509_certificate(authority.read_bytes())
    return found.fingerprint(hashes.SHA256()).hex(":").upper()


def _usable(certfile: Path, names: list[str]) -> bool:
    from cryptography import x509

    try:
        found = x509.load_pem_x509_certificate(certfile.read_bytes())
        alternatives = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (OSError, ValueError, x509.ExtensionNotFound):
        return False
    known = {str(value) for value in alternatives.get_values_for_type(x509.IPAddress)}
    known.update(alternatives.get_values_for_type(x509.DNSName))
    left = found.not_valid_after_utc - datetime.datetime.now(datetime.UTC)
    return left.days >= RENEW_DAYS and set(names) <= known


def _issue(folder: Path, names: list[str]) -> None:
    """Write a certificate for ``names``, under the authority kept in ``folder``."""
    import trustme

    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(0o700)
    public, private = folder / "authority.pem", folder / "authority.key"
    if public.is_file() and private.is_file():
        authority = trustme.CA.from_pem(public.read_bytes(), private.read_bytes())
    else:
        authority = trustme.CA(
            organization_name="pointbrush", organization_unit_name=socket.gethostname()
        )
        _write_private(private, authority.private_key_pem.bytes())
        public.write_bytes(authority.cert_pem.bytes())
    now = datetime.datetime.now(datetime.UTC)
    issued = authority.issue_cert(
        *names,
        common_name="pointbrush",
        not_before=now - datetime.timedelta(days=1),
        not_after=now + datetime.timedelta(days=CERTIFICATE_DAYS),
    )
    _write_private(folder / "server.key", issued.private_key_pem.bytes())
    chain = b"".join(blob.bytes() for blob in issued.cert_chain_pems)
    (folder / "server.pem").write_bytes(chain)


def _write_private(path: Path, content: bytes) -> None:
    """Write a file that only its owner can read, from its creation on."""
    path.unlink(missing_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(content)
