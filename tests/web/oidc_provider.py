"""A small OpenID Connect provider on loopback, which can be told to do wrong."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import parse_qs, urlencode

import uvicorn
from cryptography.hazmat.primitives.asymmetric import padding, rsa
from cryptography.hazmat.primitives.hashes import SHA256
from fastapi import FastAPI, Request
from fastapi.responses import JSONResponse, RedirectResponse

from pointbrush.web.server import listen
from tests.waiting import PATIENCE, eventually

CLIENT, SECRET = "the client", "s3cret/of:it"


def packed(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def _number(value: int) -> str:
    return packed(value.to_bytes((value.bit_length() + 7) // 8, "big"))


def published(key: rsa.RSAPrivateKey, kid: str) -> dict[str, str]:
    """The public part of a key as providers publish it."""
    public = key.public_key().public_numbers()
    return {
        "kty": "RSA", "n": _number(public.n), "e": _number(public.e), "use": "sig", "kid": kid,
    }  # fmt: skip


@dataclass
class Provider:
    """What it says of whoever comes: ``person`` are claims, ``wrong`` those that are false.

    ``header`` is that of its tokens; ``signing`` the key, which need not be the published one.
    """

    url: str
    key: rsa.RSAPrivateKey
    person: dict[str, Any] = field(default_factory=dict)
    wrong: dict[str, Any] = field(default_factory=dict)
    header: dict[str, str] = field(default_factory=lambda: {"alg": "RS256", "kid": "one"})
    signing: rsa.RSAPrivateKey | None = None
    codes: dict[str, dict[str, str]] = field(default_factory=dict)
    answering: asyncio.Event = field(default_factory=asyncio.Event)

    def token(self, nonce: str) -> str:
        now = int(time.time())
        claims = {"iss": self.url, "aud": CLIENT, "sub": "248289761001", "nonce": nonce}
        claims |= {"iat": now, "exp": now + 300} | self.person | self.wrong
        parts = [packed(json.dumps(part).encode()) for part in (self.header, claims)]
        message = ".".join(parts).encode()
        if self.header["alg"] == "none":
            return f"{message.decode()}."
        signed = (self.signing or self.key).sign(message, padding.PKCS1v15(), SHA256())
        return f"{message.decode()}.{packed(signed)}"

    def exchange(self, form: dict[str, str], authorization: str) -> dict[str, str] | None:
        asked = self.codes.pop(form.get("code", ""), None)
        known = base64.b64encode(b"the%20client:s3cret%2Fof%3Ait").decode()
        if asked is None or authorization != f"Basic {known}":
            return None
        made = packed(hashlib.sha256(form["code_verifier"].encode()).digest())
        if asked["code_challenge"] != made or asked["redirect_uri"] != form["redirect_uri"]:
            return None
        return {
            "access_token": "at",
            "token_type": "Bearer",
            "id_token": self.token(asked["nonce"]),
        }


def app_of(provider: Provider) -> FastAPI:
    app = FastAPI()

    @app.get("/.well-known/openid-configuration")
    def described() -> dict[str, str]:
        names = {"authorization_endpoint": "auth", "token_endpoint": "token", "jwks_uri": "keys"}
        places = {name: f"{provider.url}/{place}" for name, place in names.items()}
        return {"issuer": provider.url} | places

    @app.get("/keys")
    def keys() -> dict[str, Any]:
        return {"keys": [published(provider.key, provider.header.get("kid", "one"))]}

    @app.get("/auth")
    def authorize(request: Request) -> RedirectResponse:
        asked = dict(request.query_params)
        code = f"code {len(provider.codes)} {time.monotonic_ns()}"
        provider.codes[code] = asked
        told = urlencode({"code": code, "state": asked["state"]})
        return RedirectResponse(f"{asked['redirect_uri']}?{told}")

    @app.post("/token")
    async def token(request: Request) -> JSONResponse:
        body = parse_qs((await request.body()).decode())
        await provider.answering.wait()
        form = {name: values[0] for name, values in body.items()}
        given = provider.exchange(form, request.headers.get("authorization", ""))
        refused = JSONResponse({"error": "invalid_grant"}, status_code=400)
        return refused if given is None else JSONResponse(given)

    return app


@contextmanager
def providing() -> Iterator[Provider]:
    """Run a provider until the context ends."""
    listener = listen("127.0.0.1", 0)
    key = rsa.generate_private_key(65537, 2048)
    provider = Provider(f"http://127.0.0.1:{listener.getsockname()[1]}", key)
    provider.answering.set()
    server = uvicorn.Server(uvicorn.Config(app_of(provider), log_level="error"))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        eventually(lambda: server.started)
        yield provider
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        listener.close()
