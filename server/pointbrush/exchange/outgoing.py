"""HTTP calls that the server makes to other programs: bounded in bytes, time and addresses.

A call follows no redirect and unpacks no content encoding.  The host is resolved once, each
address is checked, and the connection goes to a checked address.
"""

from __future__ import annotations

import ipaddress
import socket
import ssl
import time
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from urllib.request import getproxies, proxy_bypass

import certifi
import httpcore
import httpx

from pointbrush.errors import BadInputError, ForbiddenError, UnavailableError

PIECE = 1 << 16
"""Bytes of a body that are written between two looks at the clock."""
LONGEST_URL = 2_000
GLOBAL_UNICAST = ipaddress.ip_network("2000::/3")
NAT64 = ipaddress.ip_network("64:ff9b::/96")
"""Prefix of IPv4 addresses behind a translator (RFC 6052)."""
NOT_PUBLIC = [
    ipaddress.ip_network(each) for each in ("2001::/23", "2002::/16", "3fff::/20", "192.88.99.0/24")
]
"""Teredo and other protocol assignments, 6to4, documentation, and the relays of 6to4."""


@dataclass(frozen=True, slots=True)
class Bounds:
    """Limits of one call."""

    seconds: float
    """For the whole exchange, from resolving the name to the last byte."""
    answer_bytes: int
    """Of the answer's body; 0: the body is not read."""
    public: bool = False
    """Refuse addresses of this machine and of private networks; use no proxy."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Status and body of an answer."""

    status: int
    body: bytes = b""

    @property
    def success(self) -> bool:
        """Whether the status is 2xx."""
        return 200 <= self.status < 300


def exchange(
    method: str,
    url: str,
    bounds: Bounds,
    *,
    headers: Mapping[str, str] | None = None,
    body: bytes = b"",
) -> Answer:
    """Send a request and return its answer.

    Raises BadInputError for a URL that is none, ForbiddenError for an address that is not public
    where it must be, UnavailableError for no answer within the bounds.
    """
    target = parse_url(url)
    deadline = time.monotonic() + bounds.seconds
    wire = httpcore.URL(
        scheme=target.raw_scheme, host=target.raw_host, port=target.port, target=target.raw_path
    )
    sent_headers = {
        "Host": target.netloc.decode(),
        "Accept-Encoding": "identity",
        "Content-Length": str(len(body)),
        "Connection": "close",
    } | dict(headers or {})
    try:
        with ExitStack() as stack:
            pool = stack.enter_context(_pool(target, _Network(deadline, bounds.public), bounds))
            response = stack.enter_context(
                pool.stream(method, wire, headers=list(sent_headers.items()), content=body)
            )
            answer = b"".join(_read(response.iter_stream(), bounds.answer_bytes))
            return Answer(response.status, answer)
    except httpcore.TimeoutException:
        raise UnavailableError(
            f"expected an answer within {bounds.seconds:g} s, got none"
        ) from None
    except (httpcore.NetworkError, httpcore.ProtocolError, httpcore.ProxyError, OSError) as error:
        raise UnavailableError(f"expected an answer, got {_reason(error)}") from None


def parse_url(url: str) -> httpx.URL:
    """Return an http or https URL with a host, a valid port and no password; or BadInputError."""
    got = repr(url[:80])
    try:
        parsed = httpx.URL(url)
    except (httpx.InvalidURL, ValueError):
        raise BadInputError(f"url: expected http(s)://host/…, got {got}") from None
    if parsed.scheme not in ("http", "https") or not parsed.host or len(url) > LONGEST_URL:
        raise BadInputError(f"url: expected http(s)://host/…, got {got}")
    if parsed.port is not None and not 1 <= parsed.port <= 65535:
        raise BadInputError(f"url: expected a port from 1 to 65535, got {parsed.port}")
    if parsed.userinfo:
        raise BadInputError("url: expected none with a password")
    return parsed


def resolve(host: str, port: int, *, public: bool) -> list[str]:
    """Return the addresses of a host.

    Raises BadInputError for an unknown host, and ForbiddenError if ``public`` and any of its
    addresses is not reachable from everywhere.
    """
    try:
        entries = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise BadInputError(f"url: expected a host that is known, got {host!r}") from None
    addresses = list(dict.fromkeys(str(each[4][0]) for each in entries))
    if public and not all(map(is_public, addresses)):
        raise ForbiddenError(
            f"url: expected a public address, {host!r} is of this machine or a private "
            "network (see the option webhook_private)"
        )
    return addresses


def is_public(address: str) -> bool:
    """Return whether an IP address is a single host that every network can reach."""
    ip: ipaddress.IPv4Address | ipaddress.IPv6Address
    ip = ipaddress.ip_address(address.partition("%")[0])
    if isinstance(ip, ipaddress.IPv6Address):
        if ip.ipv4_mapped is not None:
            ip = ip.ipv4_mapped
        elif ip in NAT64:
            ip = ipaddress.IPv4Address(int(ip) & 0xFFFF_FFFF)
        elif ip not in GLOBAL_UNICAST:
            return False
    if any(ip in network for network in NOT_PUBLIC if network.version == ip.version):
        return False
    return ip.is_global and not ip.is_multicast


def _read(parts: Iterable[bytes], most: int) -> Iterable[bytes]:
    """Yield the parts of a body, none if ``most`` is 0; raises UnavailableError beyond it."""
    size = 0
    if not most:
        return
    for part in parts:
        size += len(part)
        if size > most:
            raise UnavailableError(f"expected an answer of at most {most} bytes, got more")
        yield part


def _pool(url: httpx.URL, network: _Network, bounds: Bounds) -> httpcore.ConnectionPool:
    """Return a pool for one exchange, through the environment's proxy where one is set."""
    options: dict[str, Any] = {"ssl_context": _trusted(), "network_backend": network}
    proxy = None if bounds.public or proxy_bypass(url.host) else getproxies().get(url.scheme)
    if proxy is None:
        return httpcore.ConnectionPool(**options)
    return httpcore.HTTPProxy(proxy, **options)


@cache
def _trusted() -> ssl.SSLContext:
    """Trust the system's and certifi's certificate authorities."""
    context = ssl.create_default_context()
    context.load_verify_locations(certifi.where())
    return context


def _reason(error: Exception) -> str:
    return str(error) or type(error).__name__


@dataclass
class _Network(httpcore.NetworkBackend):
    """Connects to checked addresses; no step goes on beyond ``deadline``, monotonic seconds."""

    deadline: float
    public: bool
    _system: httpcore.SyncBackend = field(default_factory=httpcore.SyncBackend)

    def left(self) -> float:
        """Return the seconds left; raises ReadTimeout if there are none."""
        seconds = self.deadline - time.monotonic()
        if seconds <= 0:
            raise httpcore.ReadTimeout
        return seconds

    def connect_tcp(
        self, host: str, port: int, timeout: float | None = None,  # noqa: ARG002
        local_address: str | None = None,
        socket_options: Iterable[httpcore.SOCKET_OPTION] | None = None,
    ) -> httpcore.NetworkStream:  # fmt: skip
        """Connect to the first address of a host that answers."""
        failure: Exception = httpcore.ConnectError(f"no address of {host}")
        for address in resolve(host, port, public=self.public):
            try:
                stream = self._system.connect_tcp(
                    address, port, self.left(), local_address, socket_options
                )
                return _Stream(stream, self)
            except httpcore.ConnectError as error:
                failure = error
        raise failure


@dataclass
class _Stream(httpcore.NetworkStream):
    """A connection with reads and writes that end at the network's deadline."""

    inner: httpcore.NetworkStream
    network: _Network

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:  # noqa: ARG002
        """Read at most ``max_bytes``."""
        return self.inner.read(max_bytes, self.network.left())

    def write(self, buffer: bytes, timeout: float | None = None) -> None:  # noqa: ARG002
        """Write all of ``buffer``, a piece at a time."""
        for at in range(0, len(buffer), PIECE):
            self.inner.write(buffer[at : at + PIECE], self.network.left())

    def start_tls(
        self, ssl_context: ssl.SSLContext, server_hostname: str | None = None,
        timeout: float | None = None,  # noqa: ARG002
    ) -> httpcore.NetworkStream:  # fmt: skip
        """Encrypt the connection."""
        inner = self.inner.start_tls(ssl_context, server_hostname, self.network.left())
        return _Stream(inner, self.network)

    def get_extra_info(self, info: str) -> Any:
        """Return a fact of the connection, such as its addresses."""
        return self.inner.get_extra_info(info)

    def close(self) -> None:
        """Close the connection."""
        self.inner.close()
