"""axe-core finds nothing in any view, and the keyboard reaches everything in few steps."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, expect

from pointbrush.sequences.storage.manifest import rename_sequence, update_manifest
from tests.e2e.desk import Desk, launch
from tests.e2e.recording import SEQUENCE
from tests.e2e.server import LiveServer
from tests.waiting import eventually

AXE = Path(__file__).parents[2] / "webxr_client" / "node_modules" / "axe-core" / "axe.min.js"
FIND = """async (part) => {
  const { violations } = await axe.run(part, { resultTypes: ['violations'] });
  return violations.map(({ id, nodes }) =>
    `${id}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 200)).join(' | ')}`);
}"""


def faults(page: Page, view: str, part: str = "html") -> list[str]:
    """What axe-core calls wrong in a part of the page, however slight, with the view's name."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE.read_text(encoding="utf-8"))
    # Half faded in, words have less contrast.
    page.evaluate("document.getAnimations().forEach((each) => each.finish?.())")
    return [f"{view}: {fault}" for fault in page.evaluate(FIND, part)]


@contextmanager
def quiet_window(browser: Browser, url: str) -> Iterator[Desk]:
    """A window that draws nothing: drawing in software is slow and not looked at here."""
    window = launch(browser, url)
    try:
        window.until("window.__pointbrush !== undefined")
        window.ask("pb.setDrawing(false)")
        # Panels, and with them the heading, come after the first picture or a while.
        window.until("window.__pointbrushHeadset !== undefined")
        yield window
    finally:
        window.close()
    assert window.complaints == []


def by_button(name: str) -> Callable[[Page], None]:
    return lambda page: page.get_by_role("button", name=name, exact=True).first.click()


def a_label_menu(page: Page) -> None:
    page.get_by_role("row", name="pin 1").hover()
    by_button("More for pin 1")(page)


POPOVERS: dict[str, Callable[[Page], None]] = {
    "recordings": lambda page: page.locator(".sequence-button").click(),
    "history": by_button("History of edits"),
    "tracking": by_button("Track…"),
    "export": by_button("Export"),
    "after a stroke": by_button("After a stroke: complete the object, track the label"),
    "overlays": by_button("Overlays"),
    "clip": by_button("Clip"),
    "a label's menu": a_label_menu,
    "a label's colour": by_button("Colour of pin 1"),
    "palette": by_button("Templates and palette files"),
    "help": by_button("Keyboard and mouse"),
    "saved views": by_button("Saved views"),
    "strips": by_button("Legend of the strips"),
}

# States that come from elsewhere: a server that is away or refuses, messages, a running job.
NOTICES = ", ".join(
    f"{{id: {number}, kind: '{kind}', title: 'Title', detail: 'Detail', times: 2}}"
    for number, kind in enumerate(("info", "success", "error"))
)
JOB = f"""{{type: 'job', id: 'job', kind: 'tracking', sequence: '{SEQUENCE}', owner: '',
  state: 'running', progress: 0.5, message: 'Frame 3', frame: null, error: null, edit: null}}"""
STATES = {
    "messages": f"pb.state.notices.value = [{NOTICES}]",
    "a job": f"pb.state.jobs.value = [{JOB}]",
    "no answer": "pb.state.connection.value = {...pb.state.connection.value, state: 'offline'}",
    "connected": "pb.state.connection.value = {...pb.state.connection.value, state: 'online'}",
}


def add_recordings(server: LiveServer, count: int) -> None:
    """Put copies of the recording into the workspace of a server, which starts anew."""
    server.stop()
    for number in range(count):
        folder = server.workspace / "sequences" / f"copy{number}"
        shutil.copytree(server.workspace / "sequences" / SEQUENCE, folder)
        rename_sequence(folder, folder.name)
        update_manifest(folder, name=f"Copy {number}")
    server.start()


def settings_faults(page: Page) -> list[str]:
    """What is wrong in each tab of a project's settings, in a window of usual and of small size."""
    found: list[str] = []
    by_button("Settings")(page)
    dialog = page.get_by_role("dialog")
    expect(dialog.get_by_role("tab").first).to_be_visible()
    for tab in dialog.get_by_role("tab").all():
        tab.click()
        for height in (360, 720):
            page.set_viewport_size({"width": 1280, "height": height})
            found += faults(page, f"settings, {tab.text_content()}, {height}", "dialog")
    page.keyboard.press("Escape")
    return found


def test_no_view_has_a_fault(browser: Browser, server: LiveServer) -> None:
    for number, color in ((1, "#ff5d5d"), (2, "#2fd5e0")):
        server.create_label(SEQUENCE, f"pin {number}", color)
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/2", json={"visible": False})
    # More than the settings show at once.
    add_recordings(server, 12)
    found: list[str] = []
    with quiet_window(browser, server.page_url) as desk:
        page = desk.page
        desk.until("window.__pointbrush && pb.state.sequences.value?.length === 13")
        desk.ask(f"(pb.engine.openSequence('{SEQUENCE}'), true)")
        desk.until("pb.state.palette.value.length === 2")
        found += faults(page, "recording")
        for view, opened in POPOVERS.items():
            opened(page)
            expect(page.get_by_role("dialog")).to_have_count(1)
            found += faults(page, view, "dialog, [role=dialog]")
            page.keyboard.press("Escape")
            expect(page.get_by_role("dialog")).to_have_count(0)
        by_button("Work")(page)
        for tab in ("Tasks", "Findings", "Frames", "Agreement", "Versions"):
            page.get_by_role("tab", name=tab).click()
            found += faults(page, tab)
        by_button("By example")(page)
        found += faults(page, "by example")
        by_button("By example")(page)
        for tool in ("navigate", "pick", "boxes", "floor"):
            desk.ask(f"pb.state.tool.value = '{tool}'")
            found += faults(page, tool)
        for name, change in STATES.items():
            desk.ask(f"({change}, true)")
            found += faults(page, name)
        page.set_viewport_size({"width": 640, "height": 360})
        page.get_by_role("button", name=re.compile("^Labels")).click()
        found += faults(page, "small window")
        by_button("Close the labels")(page)
        page.set_viewport_size({"width": 1280, "height": 720})
        desk.press("Control+k")
        found += faults(page, "commands")
        page.keyboard.press("Escape")
        desk.press("y")
        page.get_by_role("button", name="Light theme").click()
        found += faults(page, "clip, light")
        desk.ask("pb.engine.closeSequence()")
        expect(page.get_by_role("heading", name="Recordings")).to_be_visible()
        found += faults(page, "start page")
        found += settings_faults(page)
    window = launch(browser, f"{server.url}/?token=wrong")
    expect(window.page.get_by_role("alert")).to_be_visible()
    found += faults(window.page, "refused")
    window.close()
    assert found == []


def focused(page: Page) -> str:
    """Name of what has the focus."""
    name: str = page.evaluate(
        "document.activeElement.ariaLabel ?? document.activeElement.textContent"
    )
    return name


def test_a_long_palette_is_worked_with_the_keyboard(browser: Browser, server: LiveServer) -> None:
    for number in range(1, 13):
        server.create_label(SEQUENCE, f"thing {number}", f"#{number * 16:02x}80ff")
        body = {"category": "odd" if number % 2 else "even"}
        server.request("PATCH", f"sequences/{SEQUENCE}/labels/{number}", json=body)
    order = f"sequences/{SEQUENCE}/palette/order"
    server.request("PUT", order, json={"labels": [3, 1, 2]})
    with quiet_window(browser, server.page_url) as desk:
        page, keyboard = desk.page, desk.page.keyboard
        desk.until("pb.state.palette.value.map(({ id }) => id).slice(0, 3).join() === '3,1,2'")
        page.locator("#view").click()
        # Numbers count as the palette lists them: six odd ones, then even ones.
        keyboard.press("Shift+Digit1")
        assert desk.ask("pb.state.activeLabel.value") == 8
        keyboard.press("1")
        assert desk.ask("pb.state.activeLabel.value") == 3
        keyboard.press("Tab")
        assert desk.ask("pb.state.activeLabel.value") == 8
        keyboard.press("/")
        keyboard.type("even 12")
        expect(page.locator(".label-row")).to_have_count(1)
        keyboard.press("Enter")
        assert desk.ask("pb.state.activeLabel.value") == 12
        expect(page.locator(".label-row")).to_have_count(12)
        expect(page.get_by_role("row", name="thing 12")).to_be_in_viewport()
        # A row is one tab stop; arrows go through rows, and into one.
        page.get_by_role("searchbox", name="Search labels").focus()
        keyboard.press("Tab")
        keyboard.press("Tab")
        assert focused(page) == "thing 12"
        keyboard.press("ArrowUp")
        keyboard.press("ArrowRight")
        assert focused(page) == "Colour of thing 10"
        keyboard.press("ArrowLeft")
        keyboard.press("Alt+ArrowUp")
        expect(page.locator(".label-row").nth(9)).to_have_accessible_name("thing 10")
        eventually(lambda: names_of(server).index("thing 10") < names_of(server).index("thing 8"))
        # A popover gives the focus back.
        for _ in range(12):  # the server's answer may put the focus back on the row
            if focused(page) == "More for thing 10":
                break
            keyboard.press("ArrowRight")
        keyboard.press("Enter")
        expect(page.get_by_role("dialog", name="thing 10")).to_be_visible()
        keyboard.press("Escape")
        assert focused(page) == "More for thing 10"
        # Radio groups and sliders answer arrows, which else are time's.
        page.get_by_role("radio", name="Paint").focus()
        keyboard.press("ArrowRight")
        assert desk.ask("[pb.state.tool.value, pb.state.frame.value]") == ["erase", 0]
        radius = desk.ask("pb.state.brush.value.radius")
        page.get_by_role("slider", name="Radius").focus()
        keyboard.press("ArrowRight")
        assert desk.ask("pb.state.brush.value.radius") > radius
        page.get_by_role("radio", name="Paint").click()
        keyboard.press("ArrowRight")
        desk.until("pb.state.frame.value === 1")
        # Templates and files, and the order by drag.
        row = page.get_by_role("row", name="thing 1", exact=True)
        target = page.get_by_role("row", name="thing 5", exact=True)
        row.drag_to(target, source_position={"x": 60, "y": 18}, target_position={"x": 60, "y": 30})
        eventually(lambda: names_of(server).index("thing 1") > names_of(server).index("thing 5"))
        by_button("Templates and palette files")(page)
        page.get_by_role("button", name="ScanNet").click()
        desk.until("pb.state.palette.value.length === 32")
        by_button("Templates and palette files")(page)
        with page.expect_download() as saved:
            page.get_by_role("button", name="Save the palette as a file").click()
        assert "thing 12" in saved.value.path().read_text(encoding="utf-8")
        assert faults(page, "long palette", "#palette") == []


def names_of(server: LiveServer) -> list[str]:
    labels: list[dict[str, Any]] = server.request("GET", f"sequences/{SEQUENCE}/labels").json()
    return [str(label["name"]) for label in labels]
