"""Generated calls of the whole API by each role, and generated messages over the socket."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import hypothesis
import msgpack
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from schemathesis.core.failures import FailureGroup
from schemathesis.generation import GenerationMode

from pointbrush.accounts.roles import ROLES
from pointbrush.teamwork.store import WorkspaceStore
from tests.faults.clients import SEQUENCE, SocketTalk
from tests.faults.server import TOKEN, running
from tests.serving import add_sequence, settings_in
from tests.torture.authors import quiet
from tests.torture.framework import Arena, Tally, scenario
from tests.waiting import PATIENCE
from tests.web.described import POINTS, described, exercise

A_ROUND = 15
"""Operations of a round, each called by every role with good or bad input."""
MESSAGES = Path(__file__).parents[2] / "golden" / "client_messages.json"
KNOWN: list[dict[str, Any]] = [
    entry["message"] | {"sequence": SEQUENCE}
    if "sequence" in entry["message"]
    else entry["message"]
    for entry in json.loads(MESSAGES.read_text())
]
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=20)
    | st.binary(max_size=20),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=8,
)


@scenario("generated calls of the whole API by each role, with good and bad input", 6)
def calls(arena: Arena) -> None:
    """Each answer is one that the description has, and none is a fault."""
    chosen = settings_in(arena.folder)
    (arena.folder / "inbox").mkdir()
    for name in ("wall", "spare"):
        add_sequence(chosen, name, frames=2, points=POINTS)
    options = {
        "POINTBRUSH_IMPORT_ROOTS": str(arena.folder / "inbox"),
        "POINTBRUSH_WRONG_TOKENS_PER_MINUTE": "1000000",
    }
    server = arena.stack.enter_context(running(chosen.workspace, **options))
    store = WorkspaceStore(f"sqlite:///{chosen.workspace / 'labels.sqlite'}")
    callers = [(store.tokens.add(role, role, None), False) for role in ROLES]
    store.close()
    with server.api() as api:
        api.post("/sequences/wall/labels", json={"name": "pin"}).raise_for_status()

    def look(answer: Any) -> None:
        arena.tally.status(answer.status_code, str(answer.content[:500]))

    operations = [result.ok() for result in described(server.url).get_all_operations()]
    turns = list(itertools.product(operations, GenerationMode))
    arena.rng.shuffle(turns)
    rest = itertools.cycle(turns)
    for number in arena.rounds():
        for operation, mode in itertools.islice(rest, A_ROUND):
            try:
                exercise(operation, mode, callers, look, examples=1, seed=arena.seed + number)
            except (AssertionError, FailureGroup) as error:
                arena.tally.count("differs", f"{operation.label}: {error}")
    quiet(server, arena.tally)


@st.composite
def messages(draw: st.DrawFn) -> bytes:
    """A message that is known, with some fields changed, or cut, or no message at all."""
    if draw(st.integers(0, 9)) == 0:
        return draw(st.binary(max_size=60))
    message = draw(st.sampled_from(KNOWN))
    names = st.sampled_from([*message, "more"])
    packed: bytes = msgpack.packb(message | draw(st.dictionaries(names, VALUES, max_size=2)))
    return packed[: draw(st.integers(0, len(packed)))] if draw(st.booleans()) else packed


@scenario("generated, changed and truncated messages over the socket", 1)
def socket_messages(arena: Arena) -> None:
    """Whoever sends them is told what is wrong, and is served after them."""
    chosen = settings_in(arena.folder)
    add_sequence(chosen, SEQUENCE, frames=3, points=POINTS)
    server = arena.stack.enter_context(running(chosen.workspace))
    for number in arena.rounds():

        @hypothesis.seed(arena.seed + number)
        @settings(
            max_examples=20,
            database=None,
            phases=[Phase.generate],
            deadline=None,
            suppress_health_check=list(HealthCheck),
        )
        @given(st.lists(messages(), min_size=1, max_size=20))
        def send(sent: list[bytes]) -> None:
            with SocketTalk(server.url, TOKEN, "ann") as talk:
                for data in sent:
                    talk.socket.send(data)
                talk.send(type="hello", name="ann")
                _until_welcome(talk, arena.tally)

        send()
    quiet(server, arena.tally)


def _until_welcome(talk: SocketTalk, tally: Tally) -> None:
    while True:
        message = msgpack.unpackb(talk.socket.recv(timeout=PATIENCE))
        if message["type"] == "error":
            tally.status(message["status"], str(message["detail"]))
        if message["type"] == "welcome":
            tally.answered += 1
            return
