"""Addresses and schemes of callers, also behind trusted proxies, and their rate limits."""

from __future__ import annotations

import ipaddress
import time

from starlette.requests import HTTPConnection

from pointbrush.errors import BadInputError, TooManyRequestsError

FORWARDING = (
    "forwarded", "via", "x-real-ip", "x-forwarded-for", "x-forwarded-host", "x-forwarded-proto",
    "x-forwarded-port", "x-forwarded-server", "x-client-ip", "true-client-ip", "cf-connecting-ip",
)  # fmt: skip
"""Headers that a proxy adds."""
SECURE = {"http": False, "https": True, "ws": False, "wss": True}
"""Whether a scheme is encrypted."""
UNKNOWN = "unknown"
BURST_SECONDS = 10
"""Default burst: a client may send the requests of this many seconds at once."""
KNOWN_CLIENTS = 10_000


class Clients:
    """Reads the addresses of callers; ``trusted`` names proxies (addresses or networks, commas)."""

    def __init__(self, trusted: str) -> None:
        """Raises BadInputError for text that is not an address or network."""
        self._trusted = []
        for text in filter(None, map(str.strip, trusted.split(","))):
            try:
                self._trusted.append(ipaddress.ip_network(text, strict=False))
            except ValueError:
                raise BadInputError(
                    f"trusted_proxies: expected addresses or networks, got {text!r}"
                ) from None

    def address(self, connection: HTTPConnection) -> str:
        """The client's address: the peer's, or the last one that a trusted proxy names.

        Other peers can write anything into the header; it is ignored for them.
        """
        found = connection.client.host if connection.client else UNKNOWN
        hops = ",".join(connection.headers.getlist("x-forwarded-for")).split(",")
        while self.trusts(found) and hops and address_in(hops[-1]) is not None:
            found = str(address_in(hops.pop()))
        return found

    def scheme(self, connection: HTTPConnection) -> str:
        """Return the client's scheme: the connection's, or the one that a trusted proxy states."""
        stated = connection.headers.get("x-forwarded-proto", "").rpartition(",")[2].strip().lower()
        peer = connection.client.host if connection.client else UNKNOWN
        own: str = connection.scope["scheme"]
        if stated not in SECURE or not self.trusts(peer):
            return own
        base = "ws" if connection.scope["type"] == "websocket" else "http"
        return f"{base}s" if SECURE[stated] else base

    def trusts(self, address: str) -> bool:
        """Return whether an address is a trusted proxy's."""
        known = address_in(address)
        return known is not None and any(known in network for network in self._trusted)

    def is_direct(self, connection: HTTPConnection) -> bool:
        """Return whether there is no proxy: no header of one, and an untrusted peer."""
        shown = any(name in connection.headers for name in FORWARDING)
        return not shown and not (connection.client and self.trusts(connection.client.host))


def address_in(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return the IP address that a text is, or None; one in brackets is of version 6."""
    try:
        found = ipaddress.ip_address(text.strip().strip("[]"))
    except ValueError:
        return None
    return getattr(found, "ipv4_mapped", None) or found


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach ``host``."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class RateLimit:
    """Token buckets by client; raises TooManyRequestsError when one is empty."""

    def __init__(self, per_second: float, burst: float | None = None) -> None:
        """``burst``: number of requests that a client may send at once."""
        self._rate = per_second
        self._burst = per_second * BURST_SECONDS if burst is None else burst
        self._buckets: dict[str, tuple[float, float]] = {}

    def spend(self, client: str, now: float | None = None) -> None:
        """Take one token of ``client``."""
        now = time.monotonic() if now is None else now
        left, since = self._buckets.pop(client, (self._burst, now))
        left = min(self._burst, left + (now - since) * self._rate)
        # Popped and put back: the dict stays in order of use, so the first is the stalest.
        self._buckets[client] = (max(left - 1.0, 0.0), now)
        if len(self._buckets) > KNOWN_CLIENTS:
            del self._buckets[next(iter(self._buckets))]
        if left < 1.0:
            raise TooManyRequestsError(f"expected at most {self._rate:g} requests a second")
