"""Each message of a page by each role: an effect only by the roles, and never a lost socket."""

from __future__ import annotations

import uuid
from typing import Any

import pytest

from pointbrush.accounts.roles import ROLES, includes
from pointbrush.client import Client
from pointbrush.streaming.roles import MESSAGES
from tests.serving import TOKEN, Served
from tests.streaming.acting import run
from tests.streaming.client import Message, Viewer, viewer
from tests.streaming.test_golden_messages import golden_client

SENT: list[Message] = [entry["message"] for entry in golden_client()]
"""Messages that the page sends, of every type."""
EVIL: list[Any] = [
    None, True, -1, 2**63, float("nan"), "", "../../etc/passwd", "x" * 100_000, [], [[]] * 5000, {},
    b"\0" * 100, [None] * 3, {"type": "open"}, [float("inf")] * 7,
]  # fmt: skip


def as_sent(message: Message) -> Message:
    """Return a message for frame 0 with an id of its own."""
    made = {key: value for key, value in message.items() if key != "identity"}
    if "id" in made:
        made["id"] = str(uuid.uuid4())
    for name in ("frame", "start", "stop"):
        if made.get(name) is not None:
            made[name] = 0
    return made | ({"sequence": "wall"} if made["type"] == "open" else {})


async def errors_after(client: Viewer, *sent: Message) -> list[Message]:
    """Send messages; returns the errors that come before the answer to an undo behind them."""
    client.log.clear()
    for message in sent:
        await client.send(**message)
    last = str(uuid.uuid4())
    await client.send(type="undo", id=last)
    errors: list[Message] = []
    while True:
        got = await client.receive()
        if got["type"] == "error" and got["about"] != last:
            errors.append(got)
        elif last in (got.get("id"), got.get("about")):
            return errors


def state(served: Served) -> tuple[list[int], list[str]]:
    """Revisions of the recordings, and all jobs."""
    labels = served.workspace.labels
    jobs = sorted(job.id for job in served.workspace.jobs.all())
    return [labels.revision(name) for name in ("wall", "other")], jobs


def test_the_page_sends_every_type() -> None:
    assert {message["type"] for message in SENT} == MESSAGES.keys()


@pytest.mark.parametrize("role", ROLES)
def test_a_message_above_a_role_is_refused_and_changes_nothing(served: Served, role: str) -> None:
    token = served.workspace.labels.tokens.add(role, f"sender {role}")
    before = state(served)

    async def scenario() -> None:
        async with viewer(served.url, token) as client:
            await client.hello()
            await client.open("wall")
            for message in map(as_sent, SENT):
                found = await errors_after(client, message)
                assert all(each["status"] < 500 for each in found), (role, message, found)
                if not includes(role, MESSAGES[message["type"]]):
                    assert [each["status"] for each in found] == [403], (role, message, found)

    run(scenario)
    if role == "viewer":
        assert state(served) == before


@pytest.fixture
def closed(served: Served) -> str:
    """The account of an annotator who may only look at ``other``; nobody else may."""
    with Client(served.url, TOKEN) as client:
        roles = {"looker": "viewer"}
        project = client.projects.create("closed", roles=roles, recordings=["other"])
        yield "looker"
        client.projects["default"].change(recordings=["other"])
        project.delete()


def test_a_closed_project_is_closed_to_every_message(served: Served, closed: str) -> None:
    tokens = served.workspace.labels.tokens
    looker, stranger = (tokens.add("annotator", name) for name in (closed, "stranger"))
    before = state(served)

    async def scenario() -> None:
        async with viewer(served.url, stranger) as client:
            await client.hello()
            found = await errors_after(client, {"type": "open", "sequence": "other"})
            assert [each["status"] for each in found] == [404]
            for message in map(as_sent, SENT):
                if message["type"] != "open":
                    found = await errors_after(client, message)
                    assert all(400 <= each["status"] < 500 for each in found), (message, found)
            assert not client.frames
        async with viewer(served.url, looker) as client:
            await client.hello()
            await client.open("other")
            for message in map(as_sent, SENT):
                if MESSAGES[message["type"]] != "viewer":
                    found = await errors_after(client, message)
                    assert [each["status"] for each in found] == [403], (message, found)

    run(scenario)
    assert state(served) == before


def mutations(message: Message) -> list[Message]:
    """Return a message without each of its fields, and with something else in each of them."""
    fields = [name for name in message if name != "type"]
    missing = [{key: value for key, value in message.items() if key != name} for name in fields]
    return missing + [message | {name: evil} for name in fields for evil in EVIL]


def test_malformed_messages_of_every_type_are_refused_in_words(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.hello()
            await client.open("wall")
            for message in map(as_sent, SENT):
                unknown = {"type": message["type"] + "x"}
                found = await errors_after(client, *mutations(message), unknown)
                assert found, message
                for each in found:
                    assert 400 <= each["status"] < 500, (message, each)
                    assert each["detail"]

    run(scenario)
