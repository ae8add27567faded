"""A peer on loopback that never answers, drips, floods, sends bombs, redirects or breaks off."""

from __future__ import annotations

import gzip
import json
import socket
import threading
import time
from collections import Counter
from contextlib import suppress
from functools import cache

from cryptography.hazmat.primitives.asymmetric import rsa

from tests.torture.listening import Listener
from tests.web.oidc_provider import published

KINDS = ("silent", "dripping", "flooding", "bombing", "redirecting", "broken")
HANGING = KINDS[:3]
"""Kinds whose answers never end."""
DRIP_SECONDS = 0.05
BOMB = 256 << 20
"""Bytes that the answer of a bombing peer unpacks to."""
BLOCK = b"10000\r\n" + bytes(1 << 16) + b"\r\n"
DESCRIPTION = "/.well-known/openid-configuration"
ELSEWHERE = "/elsewhere"
"""Place that redirections lead to."""


@cache
def _bomb() -> bytes:
    packed = gzip.compress(bytes(BOMB), 1)
    head = f"HTTP/1.1 200 OK\r\nContent-Encoding: gzip\r\nContent-Length: {len(packed)}\r\n\r\n"
    return head.encode() + packed


class HostilePeer(Listener):
    """Answers as the last part of an address says, one of KINDS; ``met`` counts these calls.

    As a provider of sign-ins it describes itself rightly while ``description`` is "", else as that
    kind; its token and keys are of the kind ``token``.  ``strayed``: calls of ELSEWHERE.
    """

    def __init__(self) -> None:
        self.description = self.token = ""
        self.met: Counter[str] = Counter()
        self.hanging = self.strayed = 0
        self._key = published(rsa.generate_private_key(65537, 2048), "one")
        self._lock = threading.Lock()
        super().__init__()

    @property
    def url(self) -> str:
        """Its address."""
        return f"http://127.0.0.1:{self.port}"

    def _handle(self, link: socket.socket) -> None:
        with link, suppress(OSError):
            request = b""
            while b"\r\n\r\n" not in request:
                part = link.recv(1 << 16)
                if not part:
                    return
                request += part
            path = request.split(b" ", 2)[1].decode().partition("?")[0]
            if path == ELSEWHERE:
                self.strayed += 1
            kind = {DESCRIPTION: self.description, "/keys": self.description, "/token": self.token}
            self._talk(link, path, kind.get(path, path.rpartition("/")[2]))

    def _talk(self, link: socket.socket, path: str, kind: str) -> None:
        if kind not in KINDS:
            self._describe(link, path)
            return
        with self._lock:
            self.met[kind] += 1
            self.hanging += kind in HANGING
        try:
            getattr(self, f"_{kind}")(link)
        finally:
            with self._lock:
                self.hanging -= kind in HANGING

    def _describe(self, link: socket.socket, path: str) -> None:
        names = {"authorization_endpoint": "auth", "token_endpoint": "token", "jwks_uri": "keys"}
        places = {name: f"{self.url}/{place}" for name, place in names.items()}
        told = {"issuer": self.url} | places if path == DESCRIPTION else {"keys": [self._key]}
        body = json.dumps(told).encode()
        link.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(body) + body)

    @staticmethod
    def _silent(link: socket.socket) -> None:
        while link.recv(1 << 16):
            pass

    @staticmethod
    def _dripping(link: socket.socket) -> None:
        link.sendall(b"HTTP/1.1 200 OK\r\nX: ")
        while True:
            link.sendall(b"x")
            time.sleep(DRIP_SECONDS)

    @staticmethod
    def _flooding(link: socket.socket) -> None:
        link.sendall(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n")
        while True:
            link.sendall(BLOCK)

    @staticmethod
    def _bombing(link: socket.socket) -> None:
        link.sendall(_bomb())

    def _redirecting(self, link: socket.socket) -> None:
        place = f"Location: {self.url}{ELSEWHERE}\r\nContent-Length: 0\r\n\r\n"
        link.sendall(f"HTTP/1.1 302 Found\r\n{place}".encode())

    @staticmethod
    def _broken(link: socket.socket) -> None:
        link.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: -5\r\nX\r\n\r\n{")
