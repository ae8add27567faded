"""A container's health check: whether the server of this container answers, with or without TLS."""

from __future__ import annotations

import ssl
import sys
import urllib.request

from pointbrush.settings import Settings

SECONDS = 2.0


def is_healthy(settings: Settings) -> bool:
    """Return whether ``/healthz`` answers on loopback."""
    # Both are tried: TLS may be set by a flag, which is not in the environment.
    return any(_is_healthy(scheme, settings.port) for scheme in ("http", "https"))


def _is_healthy(scheme: str, port: int) -> bool:
    # The certificate is for the server's public names; this call stays on the machine.
    context = ssl._create_unverified_context() if scheme == "https" else None  # noqa: S323
    try:
        url = f"{scheme}://127.0.0.1:{port}/healthz"
        with urllib.request.urlopen(url, timeout=SECONDS, context=context) as answer:  # noqa: S310
            return bool(answer.status == 200)
    except OSError:
        return False


if __name__ == "__main__":
    sys.exit(0 if is_healthy(Settings.load()) else 1)
