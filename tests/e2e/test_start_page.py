"""The start page with very many recordings: only rows in sight are drawn, and all are reached."""

from __future__ import annotations

import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from pointbrush.sequences.storage.manifest import FILE, encode_manifest, read_manifest
from pointbrush.workspace import Workspace
from tests.e2e.desk import Desk, launch
from tests.e2e.server import LiveServer
from tests.serving import add_sequence, settings_in

RECORDINGS = 2000
# A window of 720 pixels shows about 16 rows; some beyond its edges are drawn too.
MOST_DRAWN = 60


@pytest.fixture
def many(tmp_path: Path) -> Iterator[LiveServer]:
    """A server of so many recordings, which share the files of one."""
    settings = settings_in(tmp_path)
    add_sequence(settings, "r0000", frames=1, points=60)
    with closing(Workspace(settings)) as workspace:
        workspace.listing.all()
    folder = settings.workspace / "sequences"
    first, rows = read_manifest(folder / "r0000"), []
    for number in range(1, RECORDINGS):
        own = replace(first, id=f"r{number:04}", name=f"r{number:04}")
        shutil.copytree(folder / "r0000", folder / own.id, copy_function=os.link)
        (folder / own.id / FILE).unlink()
        (folder / own.id / FILE).write_bytes(encode_manifest(own))
        rows.append((own.id, own.identity))
    # The server would register them one by one.
    with closing(sqlite3.connect(settings.workspace / "labels.sqlite")) as connection:
        connection.executemany(
            "INSERT INTO sequences (id, revision, highest_label, points, identity) "
            "SELECT ?1, revision, highest_label, points, ?2 FROM sequences WHERE id = 'r0000'",
            rows,
        )
        connection.commit()
    live = LiveServer(settings.workspace)
    live.start()
    yield live
    live.stop()


def drawn(desk: Desk) -> int:
    count: int = desk.page.locator(".recording-line").count()
    return count


def test_thousands_of_recordings_are_searched_sorted_and_opened(
    browser: Browser, many: LiveServer
) -> None:
    desk = launch(browser, many.page_url)
    page = desk.page
    desk.until(f"window.__pointbrush && pb.state.sequences.value?.length === {RECORDINGS}", 120)
    rows = page.locator(".recording-line")
    expect(rows.first).to_contain_text("r0000")
    assert 10 < drawn(desk) < MOST_DRAWN
    page.locator(".home-table").evaluate("(table) => table.scrollTo(0, table.scrollHeight)")
    expect(rows.last).to_contain_text(f"r{RECORDINGS - 1}")
    assert drawn(desk) < MOST_DRAWN
    page.get_by_role("button", name="Name", exact=True).click()
    page.locator(".home-table").evaluate("(table) => table.scrollTo(0, 0)")
    expect(rows.first).to_contain_text(f"r{RECORDINGS - 1}")
    page.get_by_label("Search the recordings").fill("r12 34")
    expect(rows).to_have_count(1)
    rows.locator(".recording").click()
    desk.until("pb.state.sequence.value?.id === 'r1234'")
    # The menu of the open recording lists some, and finds the others.
    page.get_by_role("button", name="r1234", exact=True).click()
    menu = page.get_by_role("dialog", name="Recordings")
    assert menu.get_by_role("listitem").count() < MOST_DRAWN
    menu.get_by_label("Search the recordings").fill("r0777")
    menu.locator(".menu-item", has_text="r0777").click()
    desk.until("pb.state.sequence.value?.id === 'r0777'")
    assert desk.complaints == []
    desk.close()
