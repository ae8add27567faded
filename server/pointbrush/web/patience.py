"""HTTP connections that never finish a request's headers are closed: uvicorn itself would wait."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol


class PatientProtocol(H11Protocol):
    """Waits ``seconds`` for the headers of a request, however slowly their bytes come in."""

    seconds = 20.0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start waiting for the first request."""
        super().connection_made(transport)
        self._wait()

    def _wait(self) -> None:
        self.loop.call_later(self.seconds, self._look, self.scope)

    def _look(self, before: Any) -> None:
        # An upgraded connection belongs to the WebSocket's protocol, which has timeouts.
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return
        # There is no cycle before the first request.
        serving = not getattr(self.cycle, "response_complete", True)
        if self.scope is before and not serving:
            self.transport.close()
        else:
            self._wait()
