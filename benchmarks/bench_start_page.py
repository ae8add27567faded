"""Main-thread time of the start page with many recordings: open, sort, search, scroll, filter.

python benchmarks/bench_start_page.py [--recordings 2000]

The recordings are those of ``bench_projects.py``.  Times are of the page's main thread (tasks, as
Chromium counts them) from the action until the page is idle again, medians of repeats; "open" is
all from loading the page to its first rows.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from playwright.sync_api import CDPSession, Page, sync_playwright

from benchmarks.bench_projects import fill
from tests.e2e.chromium import EXECUTABLE, FLAGS
from tests.e2e.desk import launch
from tests.serving import TOKEN, serving, settings_in

REPEATS = 5
IDLE_MS = 700
"""Pause in which the page ends what an action has begun."""


def seconds(session: CDPSession) -> float:
    """Return the time of all tasks of the main thread so far."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    return next(each["value"] for each in metrics if each["name"] == "TaskDuration")


def taken(page: Page, session: CDPSession, act: Callable[[int], object]) -> float:
    """Return the median main-thread time of an action, milliseconds."""
    times = []
    for number in range(REPEATS):
        before = seconds(session)
        act(number)
        page.wait_for_timeout(IDLE_MS)
        times.append(1000 * (seconds(session) - before))
    return statistics.median(times)


def opened(page: Page, session: CDPSession) -> float:
    """Return the median main-thread time of loading the page, whose count begins anew with it."""
    times = []
    for _ in range(REPEATS):
        page.reload()
        page.locator(".recording-line").first.wait_for()
        page.wait_for_timeout(IDLE_MS)
        times.append(1000 * seconds(session))
    return statistics.median(times)


def measure(url: str, recordings: int) -> dict[str, float]:
    """Return milliseconds by action."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=EXECUTABLE, args=FLAGS)
        desk = launch(browser, url)
        desk.until(f"window.__pointbrush && pb.state.sequences.value?.length === {recordings}")
        desk.page.locator(".recording-line").first.wait_for()
        page, session = desk.page, desk.context.new_cdp_session(desk.page)
        session.send("Performance.enable")
        search, table = page.get_by_label("Search the recordings"), page.locator(".home-table")
        by = ("Points", "Labelled", "Changed", "Length", "Name")
        found = {
            "open": opened(page, session),
            "sort": taken(page, session, lambda k: page.get_by_text(by[k], exact=True).click()),
            "search": taken(page, session, lambda k: search.fill(f"r{k:02}")),
            "search for all": taken(page, session, lambda _: search.fill("")),
            "scroll": taken(
                page, session, lambda k: table.evaluate(f"t => t.scrollTop = {9000 * k}")
            ),
        }
        browser.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recordings", type=int, default=2000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        settings = settings_in(Path(folder))
        fill(settings, given.recordings)
        with serving(settings) as served:
            found = measure(f"{served.url}/?token={TOKEN}", given.recordings)
    for name, milliseconds in found.items():
        print(f"{name:16}{milliseconds:8.0f} ms")


if __name__ == "__main__":
    main()
