"""Every message of the WebSocket, once.

TypeScript is generated from these models (``pointbrush.streaming.typescript``); the subprotocol
carries a hash of their schema, so that a stale page is refused instead of misread.  A message is
one msgpack map with ``type``.  Points are numbered in *stored order* here (the progressive order
of the frame store); coordinates are metres in the source's frame unless a field says otherwise.
Packed arrays are little-endian ``bytes``.
"""

# Star imports: a new message needs no second entry here.
from pointbrush.streaming.messages.client import *  # noqa: F403
from pointbrush.streaming.messages.server import *  # noqa: F403
from pointbrush.streaming.messages.values import *  # noqa: F403
