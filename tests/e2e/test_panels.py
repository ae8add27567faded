"""The panels round the canvas: labels, timeline, tracking form, help, the start page."""

from __future__ import annotations

import io
import re
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from pointbrush.teamwork.store import WorkspaceStore
from tests.e2e.desk import Desk, launch
from tests.e2e.geometry import cut, overlaps
from tests.e2e.recording import SEQUENCE, painted
from tests.e2e.server import LiveServer
from tests.e2e.test_accessibility import faults
from tests.waiting import eventually

# Pixels of the names beside the strips.
GUTTER = 136
DATA = Path(__file__).parents[2] / "data" / "juggling"


@pytest.fixture
def desk(browser: Browser, server: LiveServer) -> Iterator[Desk]:
    """A window with two labels; drawing in software is slow and not looked at here."""
    server.create_label(SEQUENCE, "pin 1", "#ff5d5d")
    server.create_label(SEQUENCE, "pin 2", "#2fd5e0")
    window = launch(browser, server.page_url)
    window.until("window.__pointbrush !== undefined")
    window.ask("pb.setDrawing(false)")
    window.until("pb.state.palette.value.length === 2")
    window.until("document.getElementById('toolbar').childElementCount > 0")
    yield window
    window.close()
    assert window.complaints == []


def label(server: LiveServer, number: int) -> dict[str, object]:
    found: dict[str, object] = server.request("GET", f"sequences/{SEQUENCE}/labels/{number}").json()
    return found


def labels(server: LiveServer) -> list[dict[str, object]]:
    found: list[dict[str, object]] = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    return found


def has_become(server: LiveServer, number: int, **fields: object) -> bool:
    """Whether the server's label gets these fields: the page shows a change ahead of it."""
    for _ in range(200):
        if fields.items() <= label(server, number).items():
            return True
        time.sleep(0.05)
    return False


def test_a_label_is_renamed_where_it_stands(desk: Desk, server: LiveServer) -> None:
    desk.page.get_by_role("row", name="pin 1").dblclick()
    field = desk.page.get_by_role("textbox", name="Name")
    field.fill("left hand's pin")
    # Keys typed into the name are not shortcuts.
    assert desk.ask("pb.state.tool.value") == "paint"
    field.press("Enter")
    desk.until('pb.state.palette.value[0].name === "left hand\'s pin"')
    assert has_become(server, 1, name="left hand's pin")
    desk.page.get_by_role("row", name="pin 2").dblclick()
    desk.page.get_by_role("textbox", name="Name").fill("other")
    desk.page.keyboard.press("Escape")
    expect(desk.page.get_by_role("row", name="pin 2")).to_be_visible()
    assert label(server, 2)["name"] == "pin 2"


def test_a_label_is_recoloured_locked_hidden_and_deleted(desk: Desk, server: LiveServer) -> None:
    page = desk.page
    page.get_by_role("button", name="Colour of pin 1").click()
    page.get_by_role("button", name="#8ddf4a").click()
    desk.until("pb.state.palette.value[0].color === '#8ddf4a'")
    row = page.get_by_role("row", name="pin 1")
    row.hover()
    row.get_by_role("button", name="Lock").click()
    desk.until("pb.state.palette.value[0].locked")
    row.get_by_role("button", name="Hide").click()
    desk.until("!pb.state.palette.value[0].visible")
    assert has_become(server, 1, color="#8ddf4a", locked=True, visible=False)
    other = page.get_by_role("row", name="pin 2")
    other.hover()
    other.get_by_role("button", name="Show only this label").click()
    desk.until("pb.state.solo.value === 2")
    other.click(button="right")
    page.get_by_role("button", name="Delete", exact=True).last.click()
    desk.until("pb.state.palette.value.length === 1")


def test_a_new_label_is_named_at_once_and_is_like_no_other(desk: Desk, server: LiveServer) -> None:
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/2", json={"category": "pin"})
    desk.until("pb.state.palette.value[1].category === 'pin'")
    desk.press("2")
    before = desk.page.locator("#view").bounding_box()
    # No pause: what is typed is the name, whether or not the server has answered.
    desk.press("n")
    desk.page.keyboard.type("next 2")
    assert desk.ask("[pb.state.tool.value, pb.state.brush.value.shape]") == ["paint", "brush"]
    desk.page.keyboard.press("Enter")
    desk.until("pb.state.palette.value.length === 3 && pb.state.activeLabel.value === 3")
    assert has_become(server, 3, name="next 2", category="")
    assert label(server, 3)["color"] not in ("#ff5d5d", "#2fd5e0")
    desk.page.get_by_role("button", name="New label").click()
    desk.page.keyboard.press("Escape")
    desk.until("pb.state.palette.value.length === 3")
    assert desk.page.locator("#view").bounding_box() == before, "the picture moved"
    handle = desk.page.get_by_role("separator", name="Height of the timeline")
    handle.focus()
    handle.press("ArrowUp")
    after = desk.page.locator("#view").bounding_box()
    assert before is not None
    assert after is not None
    assert after["height"] == before["height"] - 18
    # The server may still be making the label that was given up.
    eventually(lambda: [row["id"] for row in labels(server)] == [1, 2, 3])


def test_a_range_is_dragged_and_tracked_by_the_form(desk: Desk, server: LiveServer) -> None:
    for frame in (1, 3):
        with np.load(DATA / f"{frame:04d}.npz") as arrays:
            truth = np.where(arrays["truth"] == 7, 1, 0).astype(np.uint16)
        put(server, frame, truth)
    # What a file brings may be tracked over; what a person vouches for may not.
    server.request("POST", f"sequences/{SEQUENCE}/frames/3/accept", json={"labels": [1]})
    desk.until("pb.state.timeline.value.rows.get(1)?.points[1] > 0")
    box = desk.page.get_by_role("slider", name="Playhead").bounding_box()
    assert box is not None
    left, width = box["x"] + GUTTER, box["width"] - GUTTER
    y = box["y"] + 36
    desk.page.mouse.move(left + width * 1.5 / 6, y)
    desk.page.mouse.down()
    desk.page.mouse.move(left + width * 4.5 / 6, y, steps=4)
    desk.page.mouse.up()
    desk.page.get_by_text("Frames 1 – 4").wait_for()
    desk.page.get_by_role("button", name="Export", exact=True).click()
    export = desk.page.get_by_role("dialog", name="Export")
    export.get_by_role("spinbutton", name="to").fill("3")
    export.get_by_role("spinbutton", name="to").press("Tab")
    expect(export.get_by_role("heading", name="Export frames 1 – 3")).to_be_visible()
    export.get_by_role("spinbutton", name="to").fill("4")
    export.get_by_role("spinbutton", name="to").press("Tab")
    desk.press("Escape")
    desk.page.locator(".pill").get_by_role("button", name="Track…").click()
    form = desk.page.get_by_role("dialog", name="Track labels")
    expect(form.get_by_role("spinbutton", name="From")).to_have_value("1")
    expect(form.get_by_role("spinbutton", name="To")).to_have_value("4")
    expect(form.get_by_role("checkbox", name="pin 1")).to_be_checked()
    form.get_by_role("checkbox", name="Only up to the next painted frame").check()
    form.get_by_text("Only up to the next painted frame").hover()
    desk.page.get_by_role("tooltip").wait_for()
    assert overlaps(desk.page, ".tooltip, .popover .check, .popover .row") == []
    form.get_by_role("button", name="Track 1 label").click()
    desk.until("pb.state.jobs.value.some((job) => job.state === 'done')")
    assert painted(server, 2, 1) > 100
    assert painted(server, 4, 1) == 0


def test_export_formats_are_grouped_and_the_last_used_is_marked(
    desk: Desk, server: LiveServer
) -> None:
    page = desk.page
    menu, details = page.get_by_role("dialog", name="Export"), page.locator(".export-details")
    opener = page.get_by_role("button", name="Export", exact=True)
    opener.click()
    expect(menu.get_by_role("region", name="Points with labels")).to_contain_text("SemanticKITTI")
    expect(menu.get_by_role("region", name="Labels only")).to_contain_text("Label arrays")
    training = menu.get_by_role("region", name="Training sets")
    expect(training).to_contain_text("Pointcept")
    expect(training.get_by_label("Validation")).to_be_visible()
    expect(menu.get_by_role("region", name="Boxes")).to_have_count(0)
    expect(menu.get_by_text("whole boxes")).to_have_count(0)
    # The losses of one format: by the pointer, then by the keyboard, which goes down the list.
    menu.get_by_role("button", name="SemanticKITTI").hover()
    expect(details.get_by_role("listitem")).to_have_text(
        ["provenance", "colours", "other point fields", "coordinates beyond 32-bit floats"]
    )
    menu.get_by_role("button", name="PLY").focus()
    expect(details).to_contain_text("PLY")
    desk.press("ArrowDown")
    expect(menu.get_by_role("button", name="NPZ")).to_be_focused()
    expect(details).to_contain_text("NPZ")
    expect(details.get_by_role("listitem")).to_have_count(0)
    assert faults(page, "export", "[role=dialog]") == []
    with page.expect_download():
        desk.press("Enter")
    box = {
        "label": 1,
        "size": [1.0, 1.0, 1.0],
        "poses": {"0": {"centre": [0.0, 0.0, 1.0], "quaternion": [0.0, 0.0, 0.0, 1.0]}},
    }
    server.request("POST", f"sequences/{SEQUENCE}/boxes", json=box)
    page.reload()
    desk.ready()
    opener.click()
    expect(menu.get_by_role("region", name="Boxes")).to_contain_text("KITTI tracking")
    expect(training).to_contain_text("OpenPCDet, whole boxes")
    expect(menu.get_by_text("last used")).to_have_count(1)
    expect(menu.get_by_role("button", name="NPZ")).to_contain_text("last used")
    expect(details).to_contain_text("NPZ")
    # A label in use without a category would be a class: its category is set from here.
    menu.get_by_text("1 label without a category").wait_for()
    menu.get_by_role("button", name="pin 1").click()
    category = page.get_by_role("dialog", name="pin 1").get_by_label("Category")
    expect(category).to_be_focused()
    category.fill("pin")
    category.press("Enter")
    assert has_become(server, 1, category="pin")
    desk.press("Escape")
    opener.click()
    expect(menu.get_by_text("without a category")).to_have_count(0)


def put(server: LiveServer, frame: int, labels: object) -> None:
    body = io.BytesIO()
    np.save(body, labels)
    path = f"sequences/{SEQUENCE}/frames/{frame}/annotation"
    server.request("PUT", path, content=body.getvalue())


# The field with the focus before anything else happens: a quick typist's next key is on its way.
FOCUSED_AT_ONCE = """async (key) => {
  const init = { ...key, bubbles: true, cancelable: true };
  document.getElementById('view').dispatchEvent(new KeyboardEvent('keydown', init));
  for (let turn = 0; turn < 20; turn++) await null;
  return document.activeElement.getAttribute('aria-label');
}"""


def test_what_is_typed_at_once_is_in_the_field_of_a_dialog(desk: Desk) -> None:
    for key, field in (("k", "Search commands"), ("?", "Search")):
        assert desk.page.evaluate(FOCUSED_AT_ONCE, {"key": key, "ctrlKey": key == "k"}) == field
        desk.press("Escape")


def test_help_lists_every_key_and_closes(desk: Desk) -> None:
    desk.press("?")
    dialog = desk.page.get_by_role("dialog", name="Keyboard and mouse")
    for what in ("Play or pause", "Eraser", "Smaller brush", "Choose a label", "Redo"):
        expect(dialog.get_by_text(what)).to_be_visible()
    # A key of one's own counts at once, and is taken from what had it.
    dialog.get_by_role("button", name="Change keys").click()
    dialog.get_by_role("button", name="Key of Loop: L").click()
    desk.press("v")
    expect(dialog.get_by_role("button", name="Key of Loop: V")).to_be_visible()
    expect(dialog.get_by_role("button", name="Key of Look around: none")).to_be_visible()
    assert faults(desk.page, "keys", "dialog") == []
    dialog.get_by_role("button", name="Done").click()
    desk.press("Escape")
    expect(dialog).to_have_count(0)
    desk.page.locator("#view").focus()
    desk.press("v")
    desk.until("!pb.state.loop.value && pb.state.tool.value === 'paint'")


def test_keys_of_ones_own_are_a_persons_in_every_browser(
    browser: Browser, server: LiveServer
) -> None:
    with closing(WorkspaceStore(f"sqlite:///{server.workspace / 'labels.sqlite'}")) as labels:
        token = labels.tokens.add("viewer", "ada")
    for n in range(2):
        desk = launch(browser, f"{server.url}/?token={token}")
        desk.ready()
        desk.press("?")
        dialog = desk.page.get_by_role("dialog", name="Keyboard and mouse")
        if n == 0:
            dialog.get_by_role("button", name="Change keys").click()
            dialog.get_by_role("button", name="Key of Loop: L").click()
            with desk.page.expect_response("**/me/keys"):
                desk.press("v")
        row = dialog.locator("dl > div", has=desk.page.get_by_text("Loop", exact=True))
        expect(row.locator("dd")).to_have_text("V")
        desk.close()


def test_the_tour_leads_a_newcomer_and_comes_once(browser: Browser, server: LiveServer) -> None:
    window = launch(browser, server.page_url, newcomer=True)
    page, card = window.page, window.page.get_by_role("dialog")
    window.until("window.__pointbrush !== undefined")
    window.ask("pb.setDrawing(false)")
    window.until("document.querySelector('.tour') !== null")
    for title, control in (
        ("Look around", ".tools [aria-label=Look]"),
        ("Choose a label", "#palette"),
        ("Paint an object", "#toolbar [aria-label=Object]"),
        ("Track it", "#toolbar button:has-text('Track')"),
        ("Export", "#toolbar button:has-text('Export')"),
    ):
        expect(card.get_by_role("heading", name=title)).to_be_visible()
        expect(page.locator(f"{control}[data-tour]")).to_be_visible()
        expect(
            card.get_by_role("button", name="Done" if title == "Export" else "Next")
        ).to_be_focused()
        assert faults(page, title, "[role=dialog]") == []
        if title == "Choose a label":
            card.get_by_role("button", name="Back").click()
            expect(card.get_by_role("heading", name="Look around")).to_be_visible()
            expect(card.get_by_role("button", name="Next")).to_be_focused()
            page.keyboard.press("Enter")
        if title == "Track it":
            page.get_by_role("button", name="Light theme").click()
            card.get_by_role("button", name="Next").focus()
        page.keyboard.press("Enter")
    expect(card).to_have_count(0)
    expect(page.locator("#view")).to_be_focused()
    assert window.ask("[pb.state.tool.value, pb.state.brush.value.shape]") == ["paint", "object"]
    page.reload()
    window.ready()
    expect(card).to_have_count(0)
    window.press("?")
    card.get_by_role("button", name="First steps").click()
    expect(card.get_by_role("heading", name="Look around")).to_be_visible()
    # From anywhere on the page, not from the card alone.
    page.locator("#view").focus()
    window.press("Escape")
    expect(card).to_have_count(0)
    window.close()
    assert window.complaints == []


def test_every_control_has_a_name_and_the_cloud_its_room(desk: Desk) -> None:
    for width, height in ((390, 844), (640, 360), (853, 480), (1280, 720), (1920, 1080)):
        desk.page.set_viewport_size({"width": width, "height": height})
        nameless = desk.page.evaluate(
            """() => [...document.querySelectorAll('button, input, select, [role=slider]')]
              .filter((e) => !(e.ariaLabel || e.textContent.trim() || e.labels?.length))
              .map((e) => e.outerHTML)"""
        )
        assert nameless == []
        # In a small window the rows of tools scroll.
        small = width < 900
        assert cut(desk.page, "#timeline *" if small else "#toolbar *, #timeline *") == []
        # The cloud has its room, and what is painted its name.
        room = desk.page.locator("#view").bounding_box()
        assert room is not None
        assert room["width"] > 0.6 * width
        assert room["height"] >= 0.5 * height
        if small:
            assert room["width"] == width
            lies_over_the_cloud(desk, "Labels", "Close the labels")
            desk.ask("pb.state.tool.value = 'boxes'")
            expect(desk.page.locator("#boxes")).to_be_visible()
            assert cut(desk.page, "#boxes header *") == []
            assert desk.page.locator("#view").bounding_box() == room
            desk.ask("pb.state.tool.value = 'paint'")
        if width == 853:
            verdicts_are_reached(desk)
        desk.press("o")
        name = desk.page.locator(".action strong")
        assert name.evaluate("(e) => e.scrollWidth <= e.clientWidth && e.clientWidth > 20")


def lies_over_the_cloud(desk: Desk, name: str, close: str) -> None:
    """A button opens a panel over the cloud, which keeps its size; another closes it."""
    room = desk.page.locator("#view").bounding_box()
    desk.page.get_by_role("button", name=re.compile(f"^{name}")).click()
    panel = desk.page.get_by_role("complementary", name=name)
    expect(panel).to_be_visible()
    assert desk.page.locator("#view").bounding_box() == room
    assert cut(desk.page, f"#app > aside[aria-label={name}] > *") == []
    panel.get_by_role("button", name=close).click()
    expect(panel).to_be_hidden()


def verdicts_are_reached(desk: Desk) -> None:
    """The buttons that judge a frame are in the sheet, none of them cut."""
    page = desk.page
    work = page.get_by_role("button", name="Work", exact=True)
    work.click()
    page.get_by_role("tab", name="Frames").click()
    for verdict in ("Mark as checked", "Needs correction"):
        button = page.get_by_role("button", name=verdict)
        button.scroll_into_view_if_needed()
        expect(button).to_be_in_viewport(ratio=1)
    page.get_by_role("button", name="Close the panel").click()


def test_the_card_of_a_job_holds_a_long_message(desk: Desk) -> None:
    message = "compiling loops, once on this machine: tracking people who meet"
    job = f"""{{ type: 'job', id: 'long', kind: 'tracking', sequence: '{SEQUENCE}', owner: '',
      state: 'running', progress: 0.5, message: '{message} {"x" * 80}',
      frame: null, error: null, edit: null }}"""
    for width in (1280, 390):
        desk.page.set_viewport_size({"width": width, "height": 844})
        desk.ask(f"(pb.state.jobs.value = [{job}])")
        card = desk.page.locator(".card.job")
        expect(card).to_contain_text(message)
        outside = card.evaluate(
            """(card) => {
              const { left, right } = card.getBoundingClientRect();
              const inside = (e) => e.left >= left && e.right <= right;
              return [...card.querySelectorAll('*')]
                .filter((each) => !inside(each.getBoundingClientRect()))
                .map((each) => each.outerHTML);
            }"""
        )
        assert outside == []


def by_keys_alone(window: Desk, server: LiveServer) -> None:
    """Label, track and export a recording that is open, without a mouse."""
    page = window.page

    def press(name: str) -> None:
        button = page.get_by_role("dialog").get_by_role("button", name=name).first
        button.focus()
        button.press("Enter")

    def command(words: str) -> None:
        window.press("Control+k")
        page.keyboard.type(words)
        expect(page.locator(".command[aria-selected=true]")).to_contain_text(words)
        window.press("Enter")

    window.ask("pb.setDrawing(true)")
    window.until("pb.shown().total > 0 && pb.shown().drawn === pb.shown().total")
    window.press("n")
    page.keyboard.type("thing")
    window.press("Enter")
    window.until("pb.state.palette.value[0]?.name === 'thing' && pb.state.activeLabel.value === 1")
    page.locator("#view").focus()
    window.press("0")
    window.settled()
    window.until("pb.state.timeline.value.rows.get(1)?.points[0] > 0")
    command("Track labels")
    press("Track 1 label")
    window.until("pb.state.timeline.value.rows.get(1)?.points[1] > 0", 60)
    command("Export points")
    with page.expect_download() as saved:
        press("PLY")
    assert saved.value.path().stat().st_size > 1000


def test_the_start_page_imports_files(browser: Browser, tmp_path: Path) -> None:
    server = LiveServer(tmp_path / "workspace")
    server.workspace.mkdir()
    server.start()
    try:
        window = launch(browser, server.page_url)
        expect(window.page.get_by_role("heading", name="No recordings yet")).to_be_visible()
        window.ask("pb.setDrawing(false)")
        with window.page.expect_file_chooser() as chooser:
            window.page.get_by_role("button", name="Choose files").click()
        chooser.value.set_files([DATA / "0000.npz", DATA / "0001.npz"])
        window.until("pb.state.importing.value?.busy === false")
        dialog = window.page.get_by_role("dialog", name="Import")
        expect(dialog.get_by_text("2, by number in the file names")).to_be_visible()
        expect(dialog.get_by_text("Other fields")).to_be_visible()
        dialog.get_by_label("Name").fill("Two frames")
        dialog.get_by_label("Name").press("Tab")
        dialog.get_by_role("button", name="Import", exact=True).click()
        window.until("pb.state.sequence.value?.frames === 2")
        expect(window.page.get_by_text("A label is one object")).to_be_visible()
        by_keys_alone(window, server)
        window.close()
        assert window.complaints == []
    finally:
        server.stop()
