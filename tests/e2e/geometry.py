"""Places of parts of the page: which lie over each other, which are cut by the window."""

from __future__ import annotations

from playwright.sync_api import Page

SHOWN = "[...document.querySelectorAll(selector)].filter((e) => e.checkVisibility())"
OVERLAPS = f"""(selector) => {{
  const parts = {SHOWN}.map((e) => [e, e.getBoundingClientRect()]);
  const over = ([a, p], [b, q]) => !a.contains(b) && !b.contains(a)
    && p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom;
  return parts.flatMap((a, i) => parts.slice(i + 1).filter((b) => over(a, b))
    .map((b) => `${{a[0].textContent}} | ${{b[0].textContent}}`));
}}"""
CUT = f"""(selector) => {SHOWN}.filter((e) => {{
  const {{ left, top, right, bottom }} = e.getBoundingClientRect();
  return left < -1 || top < -1 || right > innerWidth + 1 || bottom > innerHeight + 1;
}}).map((e) => e.outerHTML.slice(0, 120))"""


def overlaps(page: Page, selector: str) -> list[str]:
    """Return the words of each two shown elements that lie over each other."""
    found: list[str] = page.evaluate(OVERLAPS, selector)
    return found


def cut(page: Page, selector: str) -> list[str]:
    """Return the shown elements that reach out of the window."""
    found: list[str] = page.evaluate(CUT, selector)
    return found
