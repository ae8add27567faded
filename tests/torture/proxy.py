"""A TCP proxy on loopback that may be slow, and may lose an answer and its connection."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress

from tests.torture.listening import Listener

BLOCK = 1 << 16


class SlowProxy(Listener):
    """Carries connections to ``port``; each block takes ``delay`` seconds on its way.

    The next answer with all of ``lost`` in it is lost with its connection, once.
    """

    def __init__(self, port: int, delay: float = 0.0) -> None:
        self._target, self.delay = port, delay
        self.lost: tuple[bytes, ...] = ()
        super().__init__()

    def _handle(self, link: socket.socket) -> None:
        try:
            far = socket.create_connection(("127.0.0.1", self._target), timeout=5)
        except OSError:
            link.close()
            return
        far.settimeout(None)
        threading.Thread(target=self._carry, args=(far, link, True), daemon=True).start()
        self._carry(link, far, answers=False)

    def _carry(self, source: socket.socket, sink: socket.socket, answers: bool) -> None:
        with suppress(OSError):
            while block := source.recv(BLOCK):
                if answers and self.lost and all(part in block for part in self.lost):
                    self.lost = ()
                    break
                time.sleep(self.delay)
                sink.sendall(block)
        for end in (source, sink):
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
