"""The peer of the streaming benchmark: uvicorn that sends prepared messages, and nothing else."""

from __future__ import annotations

import asyncio
import itertools
import socket
import sys
from pathlib import Path

import uvicorn

PROTOCOL = "bare"


def main() -> None:
    """Serve the files of a folder, in turn, for ever."""
    messages = [path.read_bytes() for path in sorted(Path(sys.argv[1]).iterdir())]

    async def app(scope, receive, send):  # type: ignore[no-untyped-def]
        if scope["type"] != "websocket":
            return
        await receive()
        await send({"type": "websocket.accept", "subprotocol": PROTOCOL})
        try:
            for message in itertools.cycle(messages):
                await send({"type": "websocket.send", "bytes": message})
                await asyncio.sleep(0)  # or it never hears that the client has gone
        except OSError:
            return

    listener = socket.create_server(("127.0.0.1", 0))
    print(f"bare ready at http://127.0.0.1:{listener.getsockname()[1]}/?", flush=True)
    config = uvicorn.Config(
        app, ws="websockets-sansio", ws_per_message_deflate=False, log_level="error", lifespan="off"
    )
    uvicorn.Server(config).run([listener])


if __name__ == "__main__":
    main()
