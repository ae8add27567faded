"""An S3 server on loopback that goes wrong on demand: moto's, with faults before it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

from moto.moto_server.werkzeug_app import DomainDispatcherApplication, create_backend_app
from werkzeug.serving import WSGIRequestHandler, make_server

FAULTS = ("403", "500", "slow", "cut")
"""Refuses; fails; takes SLOW_SECONDS longer; sends half of what is asked for."""
SLOW_SECONDS = 1.0
WORDS = {"403": ("403 Forbidden", "AccessDenied"), "500": ("500 Internal Error", "InternalError")}
_XML = "<?xml version='1.0'?><Error><Code>{code}</Code><Message>on demand</Message></Error>"


_App = Callable[[dict[str, Any], Callable[..., Any]], Iterable[bytes]]


class _Silent(WSGIRequestHandler):
    def log(self, *_: Any) -> None:
        """Say nothing of requests, and of readers that went."""


class FaultyBucket:
    """The server until the context ends; ``fault`` is one of FAULTS, or ""."""

    def __init__(self) -> None:
        self.fault = ""
        self._app: Callable[..., Iterable[bytes]] = DomainDispatcherApplication(create_backend_app)
        self._server = make_server(
            "127.0.0.1", 0, self._answer, threaded=True, request_handler=_Silent
        )
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self._server.port}"

    def __enter__(self) -> FaultyBucket:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()

    @property
    def environment(self) -> dict[str, str]:
        """Variables of a process that uses it."""
        return {
            "AWS_ENDPOINT_URL": self.url,
            "AWS_ACCESS_KEY_ID": "somebody",
            "AWS_SECRET_ACCESS_KEY": "secret",
            "AWS_DEFAULT_REGION": "us-east-1",
            "AWS_EC2_METADATA_DISABLED": "true",
        }

    @property
    def credentials(self) -> dict[str, str]:
        """Arguments of a boto3 client that uses it."""
        return {
            "endpoint_url": self.url,
            "aws_access_key_id": "somebody",
            "aws_secret_access_key": "secret",
            "region_name": "us-east-1",
        }

    def _answer(self, environ: dict[str, Any], start: Callable[..., Any]) -> Iterable[bytes]:
        fault = self.fault
        if fault in WORDS:
            status, code = WORDS[fault]
            start(status, [("Content-Type", "application/xml")])
            return [_XML.format(code=code).encode()]
        if fault == "slow":
            time.sleep(SLOW_SECONDS)
        body = self._app(environ, start)
        if fault == "cut" and environ["REQUEST_METHOD"] == "GET":
            whole = b"".join(body)
            return [whole[: len(whole) // 2]]
        return body
