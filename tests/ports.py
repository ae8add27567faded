"""TCP ports of this machine that tests listen on."""

from __future__ import annotations

import random
import socket
from contextlib import suppress
from functools import cache

PORTS = range(15_000, 32_000)
"""Below the ports that the system gives to connections and to servers that ask for any."""


def free_port() -> int:
    """Find a port that nobody listens on."""
    for port in random.SystemRandom().sample(PORTS, len(PORTS)):
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise OSError(f"expected a free port of {PORTS}")


@cache
def kept_port() -> int:
    """Return a port for this process's servers, one after the other."""
    return free_port()


def listening(port: int) -> bool:
    """Tell whether somebody listens on a port."""
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
