"""A TCP proxy on loopback that may be slow, and may lose an answer and its connection."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress

BLOCK = 1 << 16


class SlowProxy:
    """Carries connections to ``port``; each block takes ``delay`` seconds on its way.

    The next answer with all of ``lost`` in it is lost with its connection, once.
    """

    def __init__(self, port: int, delay: float = 0.0) -> None:
        self._target, self.delay = port, delay
        self.lost: tuple[bytes, ...] = ()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        threading.Thread(target=self._accept, daemon=True).start()

    def __enter__(self) -> SlowProxy:
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                try:
                    far = socket.create_connection(("127.0.0.1", self._target), timeout=5)
                except OSError:
                    near.close()
                    continue
                far.settimeout(None)
                for ends in ((near, far, False), (far, near, True)):
                    threading.Thread(target=self._carry, args=ends, daemon=True).start()

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
