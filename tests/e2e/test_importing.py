"""Between a drop and an import: what was found, corrections, and labels for what is open."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, expect

from tests.e2e.desk import Desk, launch
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer
from tests.e2e.test_accessibility import faults
from tests.waiting import eventually


@pytest.fixture
def desk(browser: Browser, server: LiveServer) -> Iterator[Desk]:
    window = launch(browser, server.page_url)
    window.until("window.__pointbrush !== undefined")
    window.ask("pb.setDrawing(false)")
    window.until("pb.state.sequence.value !== null")
    yield window
    window.close()
    assert window.complaints == []


def choose(desk: Desk, files: list[Path]) -> Locator:
    desk.page.get_by_role("button", name=desk.ask("pb.state.sequence.value.name")).click()
    with desk.page.expect_file_chooser() as chooser:
        desk.page.get_by_role("button", name="Import files…").click()
    chooser.value.set_files(files)
    desk.until("pb.state.importing.value?.busy === false")
    return desk.page.get_by_role("dialog", name="Import")


def wide_room(folder: Path) -> list[Path]:
    """Two frames in millimetres."""
    rng = np.random.default_rng(0)
    files = [folder / f"room {i}.csv" for i in range(2)]
    for file in files:
        floor = rng.uniform([-2000, -1500, 0], [2000, 1500, 10], (3000, 3))
        wall = rng.uniform([-2000, 1490, 0], [2000, 1500, 2500], (2000, 3))
        np.savetxt(file, np.concatenate([floor, wall]), delimiter=";", fmt="%.1f")
    return files


def test_what_is_wrong_with_files_is_shown_and_corrected(
    desk: Desk, server: LiveServer, tmp_path: Path
) -> None:
    dialog = choose(desk, wide_room(tmp_path))
    expect(dialog.get_by_text("they seem to be millimetres")).to_be_visible()
    for shown in (dialog.get_by_label("Name"), dialog.get_by_role("button", name="Import").last):
        expect(shown).to_be_in_viewport(ratio=1)
    dialog.get_by_label("Unit").select_option("millimetres")
    desk.until("pb.state.importing.value.busy === false")
    expect(dialog.get_by_text("they seem to be millimetres")).to_have_count(0)
    expect(dialog.get_by_text("3.8 × 2.9 × 2.4 m")).to_be_visible()
    dialog.get_by_label("Frames per second").fill("12")
    dialog.get_by_label("Name").fill("A room")
    dialog.get_by_label("Name").press("Tab")
    dialog.get_by_role("button", name="Import", exact=True).click()
    expect(dialog).to_have_count(0)

    def rooms() -> list[dict[str, Any]]:
        return [s for s in server.request("GET", "sequences").json() if s["name"] == "A room"]

    eventually(rooms)
    (imported,) = rooms()
    assert imported["fps"] == 12
    assert imported["bounds"]["hi"][0] == pytest.approx(2, abs=0.01)


def test_an_error_can_be_answered_where_it_is_shown(
    desk: Desk, server: LiveServer, tmp_path: Path
) -> None:
    odd = tmp_path / "odd.csv"
    odd.write_text("kind;p;q;r\n" + "".join(f"{i};{i};1;2\n" for i in range(30)))
    dialog = choose(desk, [odd])
    expect(dialog.get_by_role("alert")).to_contain_text("a header with x, y and z")
    expect(dialog.get_by_role("button", name="Import", exact=True)).to_be_disabled()
    desk.complaints.clear()  # the browser's own line on an answer of 422
    dialog.get_by_label("Columns").fill("label,x,y,z")
    dialog.get_by_label("Columns").press("Tab")
    desk.until("pb.state.importing.value.busy === false")
    expect(dialog.get_by_text("included with the points")).to_be_visible()
    dialog.get_by_role("button", name="Cancel").click()
    expect(dialog).to_have_count(0)
    assert "odd" not in {s["name"] for s in server.request("GET", "sequences").json()}


def test_label_files_on_an_open_recording_are_its_labels(
    desk: Desk, server: LiveServer, tmp_path: Path
) -> None:
    count = server.request("GET", f"sequences/{SEQUENCE}").json()["points"][0]
    classes = np.zeros(count, "<u4")
    classes[:100] = 10 | 3 << 16
    (tmp_path / "000000.label").write_bytes(classes.tobytes())
    dialog = choose(desk, [tmp_path / "000000.label"])
    expect(dialog.get_by_text("100 with a label")).to_be_visible()
    before = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    dialog.get_by_role("button", name="Import labels").click()
    expect(dialog).to_have_count(0)
    desk.until("pb.state.palette.value.some((label) => label.category === 'car')")
    after = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    assert len(after) == len(before) + 1


def test_label_files_of_other_names_are_matched_by_order_when_a_person_says_so(
    desk: Desk, server: LiveServer, tmp_path: Path
) -> None:
    counts = server.request("GET", f"sequences/{SEQUENCE}").json()["points"]
    files = [tmp_path / f"{letter}.label" for letter in "abcdef"]
    for file, count in zip(files, counts, strict=True):
        file.write_bytes((np.arange(count) < 50).astype("<u4").tobytes())
    dialog = choose(desk, files)
    expect(dialog.get_by_role("alert")).to_contain_text("got 6 of no frame: a.label")
    expect(dialog.get_by_role("button", name="Import labels")).to_be_disabled()
    dialog.get_by_label("Match files to frames by order").check()
    row = dialog.get_by_role("row", name="c.label")
    expect(row).to_contain_text("2")
    expect(dialog.get_by_role("alert")).to_have_count(0)
    dialog.get_by_role("button", name="Import labels").click()
    expect(dialog).to_have_count(0)
    told = desk.page.locator(".toast")
    expect(told).to_contain_text(
        "300 points in 6 frames. a.label → 0, b.label → 1, c.label → 2, 3 more"
    )
    assert (server.annotation(SEQUENCE, 2) > 0).sum() == 50


def test_a_recording_whose_labels_did_not_come_in_is_tried_again(
    desk: Desk, server: LiveServer
) -> None:
    def database(statement: str) -> None:
        with closing(sqlite3.connect(server.workspace / "labels.sqlite")) as connection:
            connection.execute(statement)
            connection.commit()

    database(
        "CREATE TRIGGER full BEFORE INSERT ON edits WHEN NEW.kind = 'import' "
        "BEGIN SELECT RAISE(ABORT, 'no room for labels'); END"
    )
    rows = "".join(f"{i} {i} 0 {i % 2}\n" for i in range(20))
    files = {"files": ("street.csv", f"x y z label\n{rows}")}
    server.request("POST", "sequences", files=files)

    def street() -> list[dict[str, Any]]:
        return [s for s in server.request("GET", "sequences").json() if s["name"] == "street"]

    eventually(street)
    desk.page.get_by_role("button", name="Juggling").click()
    desk.page.get_by_role("button", name="All recordings").click()
    line = desk.page.locator(".recording-line", has_text="street")
    expect(line).to_contain_text("Labels were not imported:")
    expect(line).to_contain_text("no room for labels")
    database("DROP TRIGGER full")
    line.get_by_role("button", name="Try again").click()
    expect(line).to_contain_text("1 of 1 frame")
    desk.complaints.clear()
    assert (server.annotation(street()[0]["id"], 0) > 0).sum() == 10


def drives(folder: Path, count: int) -> Path:
    """A folder of recordings of two frames, and a file that is none."""
    for number in range(1, count + 1):
        (folder / f"drive_{number}").mkdir(parents=True)
        for frame in range(2):
            rows = "".join(f"{x} {frame} 0\n" for x in range(20))
            (folder / f"drive_{number}" / f"{frame}.xyz").write_text(rows)
    (folder / "notes.md").write_text("By car\n")
    return folder


def test_a_folder_of_recordings_is_previewed_and_comes_in_on_one_card(
    desk: Desk, server: LiveServer, tmp_path: Path
) -> None:
    page = desk.page
    desk.until("pb.state.sequences.value !== null")  # before, the page opens the only one
    desk.ask("pb.engine.closeSequence()")
    for name in ("Filter", "New project", "Import"):
        page.get_by_role("button", name=name, exact=True).click()
        assert faults(page, name) == []
        desk.press("Escape")
    page.get_by_role("button", name="Import", exact=True).click()
    box = page.get_by_role("dialog", name="Import")
    box.get_by_label("Or a path on the server").fill(str(drives(tmp_path / "in", 6)))
    box.get_by_label("Import each file or folder in it as a recording").check()
    box.get_by_role("button", name="Import", exact=True).click()
    desk.until("pb.state.importing.value?.busy === false")
    rows = page.get_by_role("region", name="Recordings to import").get_by_role("row")
    expect(rows.filter(has_text="drive_2")).to_contain_text("2")
    unreadable = rows.filter(has_text="notes.md")
    expect(unreadable.locator(".bad")).to_contain_text("expected")
    expect(unreadable.get_by_role("checkbox")).not_to_be_checked()
    desk.complaints.clear()  # the browser's own line on an answer of 422
    rows.filter(has_text="drive_6").get_by_role("checkbox").uncheck()
    assert faults(page, "preview") == []
    page.get_by_role("button", name="Import 5 recordings").click()
    card = page.get_by_role("region", name="Imports")
    card.get_by_role("button", name="Show each").click()
    expect(card.get_by_role("listitem")).to_have_count(5)
    expect(card).to_contain_text("Imported 5 recordings")
    assert faults(page, "start page with imports") == []
    # Nothing opened by itself, and no message covers the page.
    assert desk.ask("pb.state.sequence.value") is None
    expect(page.locator(".toast")).to_have_count(0)
    names = {each["name"] for each in server.request("GET", "sequences").json()}
    assert names == {"Juggling", *(f"drive_{number}" for number in range(1, 6))}
    third = card.get_by_role("listitem").filter(has_text="drive_3")
    third.get_by_role("button", name="Open").click()
    desk.until("pb.state.sequence.value?.id === 'drive-3'")
    card.get_by_role("button", name="Close").click()
    expect(card).to_have_count(0)
