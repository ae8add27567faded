"""Calls of other programs end in time, whatever these answer."""

from __future__ import annotations

import gzip
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest

from pointbrush.errors import BadInputError, ForbiddenError, UnavailableError
from pointbrush.exchange.outgoing import Answer, Bounds, exchange, is_public, parse_url
from tests.waiting import PATIENCE

BOUNDS = Bounds(seconds=1.0, answer_bytes=1000)
Talk = Callable[[socket.socket], None]


@contextmanager
def peer(talk: Talk) -> Iterator[str]:
    """Serve one connection with ``talk``, after the request's header has come."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def serve() -> None:
            link, _ = listener.accept()
            with link:
                while b"\r\n\r\n" not in link.recv(65536):
                    pass
                with suppress(OSError):
                    talk(link)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/hook"
        thread.join(PATIENCE)
        assert not thread.is_alive()


def dripping(start: bytes) -> Talk:
    def talk(link: socket.socket) -> None:
        link.sendall(start)
        while True:
            link.sendall(b"x")
            time.sleep(0.05)

    return talk


def flood(link: socket.socket) -> None:
    link.sendall(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n")
    while True:
        link.sendall(b"10000\r\n" + bytes(65536) + b"\r\n")


def silent(link: socket.socket) -> None:
    link.recv(1)  # until the other side leaves


@pytest.mark.parametrize(
    "talk", [silent, dripping(b""), dripping(b"HTTP/1.1 200 OK\r\nX: "), dripping(
        b"HTTP/1.1 200 OK\r\nContent-Length: 900\r\n\r\n"
    )], ids=["silent", "status", "header", "body"],
)  # fmt: skip
def test_a_peer_that_does_not_come_to_an_end_is_left(talk: Talk) -> None:
    with (
        peer(talk) as url,
        pytest.raises(UnavailableError, match=r"within 1 s|peer|invalid|illegal"),
    ):
        exchange("POST", url, BOUNDS, body=b"{}")


def test_no_more_is_read_than_allowed() -> None:
    with peer(flood) as url, pytest.raises(UnavailableError, match="at most 1000 bytes"):
        exchange("GET", url, BOUNDS)
    with peer(flood) as url:
        assert exchange("POST", url, Bounds(5.0, answer_bytes=0)) == Answer(200)


def test_an_encoded_body_is_not_unpacked() -> None:
    body = gzip.compress(bytes(10_000_000))[:900]

    def talk(link: socket.socket) -> None:
        length = f"Content-Length: {len(body)}\r\n\r\n".encode()
        link.sendall(b"HTTP/1.1 200 OK\r\nContent-Encoding: gzip\r\n" + length + body)

    with peer(talk) as url:
        assert exchange("GET", url, BOUNDS) == Answer(200, body)


def test_no_redirect_is_followed() -> None:
    def talk(link: socket.socket) -> None:
        link.sendall(b"HTTP/1.1 302 Found\r\nLocation: http://127.0.0.1:1/\r\n\r\n")

    with peer(talk) as url:
        assert exchange("GET", url, BOUNDS).status == 302


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1", "10.1.2.3", "169.254.169.254", "100.64.0.1", "0.0.0.0", "224.0.0.1",
        "240.0.0.1", "255.255.255.255", "192.88.99.1", "::1", "::", "::7f00:1", "::ffff:10.0.0.1",
        "64:ff9b::a00:1", "64:ff9b:1::1", "2002:a00:1::1", "2001:0:4136:e378::1", "fe80::1%eth0",
        "fec0::1", "fc00::1", "ff02::1", "2001:db8::1", "3fff::1", "5f00::1",
    ],
)  # fmt: skip
def test_addresses_of_networks_behind_the_server_are_not_public(address: str) -> None:
    assert not is_public(address)


@pytest.mark.parametrize(
    "address", ["93.184.216.34", "2606:2800:220:1::1", "64:ff9b::5db8:d822", "::ffff:93.184.216.34"]
)
def test_addresses_of_the_internet_are_public(address: str) -> None:
    assert is_public(address)


def test_a_call_for_the_public_connects_to_no_private_address() -> None:
    with pytest.raises(ForbiddenError, match="public"):
        exchange("GET", "http://127.0.0.1:9/", Bounds(5.0, 0, public=True))


@pytest.mark.parametrize(
    "url",
    [
        "ftp://a/", "http:///x", "https://ada:secret@example.org/", "http://a:0/", "http://a:65536/",
        "http://a:-1/", "http://[::1/", f"http://a/{'x' * 3000}",
    ],
)  # fmt: skip
def test_what_is_no_address_is_refused(url: str) -> None:
    with pytest.raises(BadInputError, match="url"):
        parse_url(url)
