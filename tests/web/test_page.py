"""The built page: the shortest form that a browser reads, kept for ever where it can be."""

from __future__ import annotations

import gzip
from pathlib import Path

import httpx
import pytest

from pointbrush.web import page
from tests.serving import Served

SCRIPT = b"console.log('points');\n" * 100


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "assets").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html>")
    script = tmp_path / "assets" / "main-1a2b.js"
    script.write_bytes(SCRIPT)
    script.with_name("main-1a2b.js.gz").write_bytes(gzip.compress(SCRIPT))
    script.with_name("main-1a2b.js.br").write_bytes(b"brotli")
    monkeypatch.setattr(page, "PAGE", tmp_path)
    return script


@pytest.mark.parametrize(
    ("accepted", "encoding"),
    [
        ("gzip, deflate, br, zstd", "br"),
        ("gzip, deflate", "gzip"),
        ("br;q=0, gzip;q=0.5", "gzip"),
        ("identity", None),
    ],
)
def test_scripts_come_in_the_shortest_form(
    anyone: httpx.Client, built: Path, accepted: str, encoding: str | None
) -> None:
    with anyone.stream(
        "GET", "/assets/main-1a2b.js", headers={"Accept-Encoding": accepted}
    ) as answer:
        raw = b"".join(answer.iter_raw())
    ending = {"br": ".br", "gzip": ".gz", None: ""}[encoding]
    assert raw == built.with_name(built.name + ending).read_bytes()
    assert answer.headers.get("content-encoding") == encoding
    assert answer.headers["content-type"].startswith("text/javascript")
    assert answer.headers["vary"] == "Accept-Encoding"
    assert "immutable" in answer.headers["cache-control"]


def test_models_of_controllers_have_their_type(anyone: httpx.Client, built: Path) -> None:
    (built.parent / "left-1a2b.glb").write_bytes(b"glTF")
    answer = anyone.get("/assets/left-1a2b.glb")
    assert answer.headers["content-type"] == "model/gltf-binary"
    assert "immutable" in answer.headers["cache-control"]


def test_the_document_is_asked_for_again_each_time(anyone: httpx.Client, built: Path) -> None:
    answer = anyone.get("/")
    assert answer.text == "<!doctype html>"
    assert answer.headers["cache-control"] == "no-cache"
    assert answer.headers["content-type"].startswith("text/html")


BROWSER = {"Accept": "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}


def test_a_browser_with_a_wrong_token_gets_the_page_that_says_so(
    anyone: httpx.Client, built: Path
) -> None:
    refused = anyone.get("/?token=wrong&sequence=wall", headers=BROWSER)
    assert (refused.status_code, refused.text) == (401, "<!doctype html>")
    assert refused.headers["content-type"].startswith("text/html")
    assert "www-authenticate" in refused.headers
    assert "set-cookie" not in refused.headers
    for accept in ("application/json", "*/*"):
        plain = anyone.get("/?token=wrong", headers={"Accept": accept})
        assert plain.status_code == 401
        assert plain.headers["content-type"] == "application/problem+json"


def test_the_check_of_a_headset_is_the_page_at_an_address_of_its_own(
    anyone: httpx.Client, served: Served, built: Path
) -> None:
    assert anyone.get("/check-headset").text == "<!doctype html>"
    answer = anyone.get(f"/check-headset?token={served.token}&sequence=wall")
    assert answer.status_code == 303
    assert answer.headers["location"] == "/check-headset?sequence=wall"
    assert "set-cookie" in answer.headers


def test_the_page_of_a_participant_finds_its_files_in_the_folder_above(
    anyone: httpx.Client, built: Path
) -> None:
    (built.parents[1] / "index.html").write_text('<script src="./assets/main-1a2b.js"></script>')
    answer = anyone.get("/study/some-code")
    assert answer.headers["cache-control"] == "no-cache"
    assert "content-security-policy" in answer.headers
    assert answer.text == '<script src="../assets/main-1a2b.js"></script>'
    assert anyone.get("/study/../assets/main-1a2b.js").content == SCRIPT
