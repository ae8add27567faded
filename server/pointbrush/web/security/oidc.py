"""Sign-in by OpenID Connect: the authorization code flow with PKCE, state and nonce.

OpenID Connect Core 1.0, section 3.1; RFC 7636 (PKCE); RFC 9207 (issuer of an answer).  An ID token
is valid if a key of the provider has signed it by one of ``ALGORITHMS``, and issuer, audience,
times and nonce are correct.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import logging
import secrets
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote, urlencode, urlsplit

from authlib.oauth2.rfc6749.parameters import prepare_grant_uri
from authlib.oauth2.rfc7636 import create_s256_code_challenge
from authlib.oidc.core import CodeIDToken
from joserfc import jwt
from joserfc.errors import InvalidKeyIdError, JoseError
from joserfc.jwk import KeySet

from pointbrush.accounts.roles import ROLES, Role
from pointbrush.accounts.signing_keys import SigningKeys
from pointbrush.errors import (
    BadInputError,
    ForbiddenError,
    PointbrushError,
    UnauthorizedError,
    UnavailableError,
)
from pointbrush.exchange.outgoing import Answer, Bounds, exchange
from pointbrush.settings import Settings
from pointbrush.web.security.clients import is_loopback

ALGORITHMS = ("RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512")
"""Accepted signatures: not ``none``, and no symmetric ones, because the client has their key."""
PURPOSE = "oidc"
SCOPE = "openid profile email"
FLOW_SECONDS = 600
"""Time in which a sign-in must be completed."""
BOUNDS = Bounds(seconds=10.0, answer_bytes=1 << 20)
"""Bounds of one call of the provider."""
LEEWAY_SECONDS = 60
"""Accepted error of the provider's clock."""
KNOWN_SECONDS = 3600.0
"""Age from which the provider's description and keys are read again."""
RETRY_SECONDS = 30.0
"""Shortest time between two tries to read them."""
log = logging.getLogger(__name__)

ENDPOINTS = ("authorization_endpoint", "token_endpoint", "jwks_uri")


@dataclass(frozen=True, slots=True)
class Person:
    """A person from the provider; ``role`` is None if no claim contains it.

    ``subject`` identifies the person permanently; ``names`` are their possible names, the best
    first.
    """

    subject: str
    names: tuple[str, ...]
    role: Role | None


@dataclass(frozen=True, slots=True)
class _Known:
    """Description of the provider and its keys, and when they were read."""

    endpoints: Mapping[str, Any]
    keys: KeySet
    read: float


class _Flow:
    """Values of one sign-in, derived from its browser's cookie and a secret key."""

    def __init__(self, key: bytes, kept: str) -> None:
        self._key, self.kept = key, kept
        self.state = self._made("state")
        self.nonce = self._made("nonce")
        self.verifier = self._made("verifier")

    def _made(self, what: str) -> str:
        message = f"{what} {self.kept}".encode("utf-8", "surrogateescape")
        return hmac.digest(self._key, message, "sha256").hex()

    def accepts(self, state: str) -> bool:
        """Return whether an answer with ``state`` belongs to this sign-in and is in time."""
        right = hmac.compare_digest(state.encode("utf-8", "surrogateescape"), self.state.encode())
        return right and time.time() < float(self.kept.rpartition(".")[2])


class Provider:
    """The provider that people sign in with; thread-safe."""

    flow_seconds = FLOW_SECONDS

    def __init__(self, settings: Settings, keys: SigningKeys) -> None:
        """Raises BadInputError for invalid settings; does not call the provider yet."""
        self._issuer, self._client = settings.oidc_issuer, settings.oidc_client_id
        self._secret, self._claim = settings.oidc_client_secret, settings.oidc_roles_claim
        if not self._client:
            raise BadInputError("oidc_client_id: expected one with oidc_issuer, got none")
        if settings.oidc_role not in ROLES:
            raise BadInputError(
                f"oidc_role: expected one of {', '.join(ROLES)}, got {settings.oidc_role!r}"
            )
        _require_private("oidc_issuer", self._issuer)
        self.first_role: Role = settings.oidc_role
        self.name = urlsplit(self._issuer).netloc
        self._keys = keys
        self._known: _Known | None = None
        self._reading: Future[_Known] | None = None
        self._tried = -RETRY_SECONDS
        self._lock = threading.Lock()

    def begin(self, redirect: str) -> tuple[str, str]:
        """Begin a sign-in that returns to ``redirect``.

        Returns the address for the browser, and the value of its cookie until then.  Raises
        UnavailableError.
        """
        kept = f"{secrets.token_urlsafe(32)}.{int(time.time()) + FLOW_SECONDS}"
        flow = _Flow(self._keys.get(PURPOSE), kept)
        address = prepare_grant_uri(
            self._look().endpoints["authorization_endpoint"],
            self._client,
            "code",
            redirect_uri=redirect,
            scope=SCOPE,
            state=flow.state,
            nonce=flow.nonce,
            code_challenge=create_s256_code_challenge(flow.verifier),
            code_challenge_method="S256",
        )
        return str(address), kept

    def finish(self, kept: str, answer: Mapping[str, str], redirect: str) -> Person:
        """Return the person of the provider's ``answer``, a query, to the sign-in ``kept``.

        Raises UnauthorizedError for an answer to another sign-in, a refusal or an invalid answer,
        ForbiddenError for a person without a role, and UnavailableError.
        """
        flow = _Flow(self._keys.get(PURPOSE), kept)
        if not flow.accepts(answer.get("state", "")):
            raise UnauthorizedError(
                "state: expected that of a sign-in which this browser began within "
                f"{FLOW_SECONDS // 60} minutes, got another"
            )
        if answer.get("iss", self._issuer) != self._issuer:
            raise UnauthorizedError("iss: expected the provider's issuer, got another")
        if "code" not in answer:
            reason = answer.get("error", "no code")[:60]
            raise UnauthorizedError(f"sign-in: expected the provider's code, got {reason!r}")
        tokens = self._exchange(answer["code"], flow.verifier, redirect)
        return self._person(self._claims(tokens, flow.nonce))

    def _exchange(self, code: str, verifier: str, redirect: str) -> Mapping[str, Any]:
        """Exchange a code for the provider's tokens."""
        endpoints = self._look().endpoints
        form = {
            "grant_type": "authorization_code",
            "code": code,
            "redirect_uri": redirect,
            "client_id": self._client,
            "code_verifier": verifier,
        }
        ways = endpoints.get("token_endpoint_auth_methods_supported", ["client_secret_basic"])
        headers = {"Content-Type": "application/x-www-form-urlencoded"}
        if self._secret and "client_secret_basic" in ways:
            pair = f"{quote(self._client, safe='')}:{quote(self._secret, safe='')}"
            headers["Authorization"] = f"Basic {base64.b64encode(pair.encode()).decode()}"
        elif self._secret:
            form["client_secret"] = self._secret
        with _provider_call():
            address, body = endpoints["token_endpoint"], urlencode(form).encode()
            answer = exchange("POST", address, BOUNDS, headers=headers, body=body)
            if 400 <= answer.status < 500:
                raise UnauthorizedError(
                    "code: expected one that the provider takes, got one that it refused",
                    private=answer.body[:200].decode(errors="replace"),
                )
            return _object(answer)

    def _claims(self, tokens: Mapping[str, Any], nonce: str) -> Mapping[str, Any]:
        """Return the claims of the ID token in the provider's answer, after checking it."""
        token = tokens.get("id_token")
        try:
            if not isinstance(token, str):
                raise ValueError("no ID token")  # noqa: TRY004 – as all that is wrong with it
            decoded = self._decoded(token)
            claims = CodeIDToken(
                decoded.claims,
                decoded.header,
                {"iss": {"value": self._issuer}, "aud": {"value": self._client}},
                {"nonce": nonce, "client_id": self._client,
                 "access_token": tokens.get("access_token")},
            )  # fmt: skip
            claims.validate(leeway=LEEWAY_SECONDS)
            if not claims["sub"]:
                raise ValueError("no subject")
        except (JoseError, ValueError, TypeError) as error:
            raise UnauthorizedError(
                "ID token: expected a valid one for this sign-in, got another",
                private=f"{type(error).__name__}: {error}",
            ) from None
        return dict(claims)

    def _decoded(self, token: str) -> jwt.Token:
        """Check the signature; an unknown key may be newer than the keys read before."""
        try:
            return jwt.decode(token, self._look().keys, algorithms=ALGORITHMS)
        except InvalidKeyIdError:
            return jwt.decode(token, self._look(RETRY_SECONDS).keys, algorithms=ALGORITHMS)

    def _person(self, claims: Mapping[str, Any]) -> Person:
        subject = hashlib.sha256(f"{self._issuer}\0{claims['sub']}".encode()).hexdigest()
        verified = ("email",) if claims.get("email_verified") is True else ()
        candidates = (claims.get(name) for name in (*verified, "preferred_username", "sub"))
        names = tuple(name for name in candidates if isinstance(name, str) and name)
        return Person(subject, names, self._role(claims) if self._claim else None)

    def _role(self, claims: Mapping[str, Any]) -> Role:
        """Return the highest role that the claim has."""
        claim = _within(claims, self._claim)
        roles = claim if isinstance(claim, list) else [claim]
        known = [role for role in ROLES if role in roles]
        if not known:
            raise ForbiddenError(
                f"{self._claim}: expected one of the roles {', '.join(ROLES)} at the provider, "
                "got none"
            )
        return known[-1]

    def _look(self, oldest: float = KNOWN_SECONDS) -> _Known:
        """Return the provider's description and keys, read again once older than ``oldest`` s.

        One caller reads them.  Other callers get the known ones at once, or wait if none are known.
        Known ones stay in use while the provider is unavailable.  Raises UnavailableError.
        """
        with self._lock:
            now, known, reading = time.monotonic(), self._known, self._reading
            if known is not None and (now - known.read < oldest or reading is not None):
                return known
            if reading is None:
                if now - self._tried < RETRY_SECONDS:
                    if known is None:
                        raise UnavailableError(
                            "sign-in: expected the provider to answer, it did not"
                        )
                    return known
                self._tried, mine = now, Future[_Known]()
                self._reading = mine
        return reading.result() if reading is not None else self._refresh(mine, known, now)

    def _refresh(self, reading: Future[_Known], known: _Known | None, now: float) -> _Known:
        """Read the provider's description and keys for all callers that wait."""
        try:
            reading.set_result(self._read(now))
        except PointbrushError as error:
            if known is None:
                reading.set_exception(error)
            else:
                log.warning("%s", error.whole)
                reading.set_result(known)
        with self._lock:
            self._reading = None
            self._known = known if reading.exception() else reading.result()
        return reading.result()

    def _read(self, now: float) -> _Known:
        """Ask the provider for its description and keys."""
        with _provider_call():
            described = _fetch(f"{self._issuer.rstrip('/')}/.well-known/openid-configuration")
            if described.get("issuer") != self._issuer:
                raise ValueError(f"issuer {described.get('issuer')!r}")
            for name in ENDPOINTS:
                _require_private(name, described[name])
            key_set = _fetch(described["jwks_uri"])
            # Ignore keys for encryption and keys of other kinds.
            usable = [key for key in key_set["keys"] if key.get("use", "sig") == "sig"]
            kinds = [key for key in usable if key.get("kty") in ("RSA", "EC")]
            return _Known(described, KeySet.import_key_set({"keys": kinds}), now)


def _fetch(address: str) -> dict[str, Any]:
    """Return the JSON object at an address of the provider."""
    answer = exchange("GET", address, BOUNDS)
    if not answer.success:
        raise ValueError(f"status {answer.status}")
    return _object(answer)


@contextmanager
def _provider_call() -> Iterator[None]:
    """Raise UnavailableError if the provider does not answer or answers invalid data."""
    try:
        yield
    except UnauthorizedError:
        raise
    except (
        PointbrushError, JoseError, ValueError, KeyError, TypeError, AttributeError, RecursionError,
    ) as error:  # fmt: skip
        raise UnavailableError(
            "sign-in: expected a right answer of the provider, got none",
            private=f"{type(error).__name__}: {error}",
        ) from None


def _object(answer: Answer) -> dict[str, Any]:
    """Return the JSON object of an answer; raises ValueError for anything else."""
    document = json.loads(answer.body)
    if not isinstance(document, dict):
        raise ValueError("no JSON object")  # noqa: TRY004 – of the answer, not of our call
    return document


def _within(claims: Mapping[str, Any], path: str) -> Any:
    """Return a claim by its name, or by names with dots from the outermost on."""
    value: Any = claims
    for name in (path,) if path in claims else path.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return value


def _require_private(what: str, address: str) -> None:
    """Raise BadInputError for an address without encryption, except on this machine."""
    parts = urlsplit(address)
    local = parts.scheme == "http" and is_loopback(parts.hostname or "")
    if not (parts.hostname and (parts.scheme == "https" or local)):
        raise BadInputError(f"{what}: expected an https address, got {address[:100]!r}")
