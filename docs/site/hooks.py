"""Pages of the site that are written from the program, and files above docs/."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

import example_pages
import rest_pages
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Navigation
from mkdocs.structure.pages import Page
from python_page import python

from pointbrush.cli import parser

ROOT = Path(__file__).parents[2]
WIDE = (
    "conventions.md",
    "headset-devices.md",
    "options.md",
    "roles.md",
    "tracking-ablation.md",
)
"""Pages of tables that take the room of the contents beside them."""
PAGES: list[Page] = []
"""Pages in the order of the navigation."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are no files of docs/."""
    pages = {
        "reference/cli.md": command_line(),
        "reference/python.md": python(),
        "reference/changelog.md": above("CHANGELOG.md"),
        "explanation/architecture.md": above("ARCHITECTURE.md"),
    }
    pages |= rest_pages.pages() | example_pages.pages()
    for place, text in pages.items():
        files.append(File.generated(config, place, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Lead links to examples to their pages, and leave wide tables their room."""
    if page.file.src_uri in WIDE:
        page.meta["hide"] = ["toc"]
    return example_pages.linked(markdown)


def on_nav(nav: Navigation, **_: object) -> None:
    """Keep the order of the pages for ``llms.txt``."""
    PAGES[:] = nav.pages


def on_post_build(config: MkDocsConfig) -> None:
    """List all pages in ``llms.txt``, with their first words."""
    lines = [f"# {config.site_name}", "", f"> {config.site_description}", ""]
    section = None
    for page in PAGES:
        above = page.ancestors[-1].title if page.ancestors else "Start"
        if above != section:
            lines += ["", f"## {above}", ""]
            section = above
        lines.append(f"- [{page.title}]({page.url}): {_opening(page.markdown or '')}")
    (Path(config.site_dir) / "llms.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _opening(markdown: str) -> str:
    """Return a page's first sentence as plain text."""
    prose = re.sub(r"^```.*?^```|^#.*?$|^<!--.*?-->", "", markdown, flags=re.M | re.S)
    for part in re.split(r"\n\s*\n", prose):
        if (text := part.lstrip("\n")) and text[0] not in "!|:- ":
            plain = re.sub(r"\]\([^)]*\)|[\[\]*`]", "", " ".join(text.split()))
            return re.split(r"(?<=\.) ", plain)[0]
    return "see there"


def above(name: str) -> str:
    """Return a page of the repository's top, whose links into docs/ lead to the site's pages."""
    text = (ROOT / name).read_text(encoding="utf-8")
    return re.sub(r"\]\(docs/", "](../", text)


def command_line() -> str:
    """Return the reference of all commands, from the parser."""
    lines = ["# The command line", "", "What the flags mean in full: [options](../options.md).", ""]
    for name, command in _commands(parser()):
        lines += [f"## pointbrush {name}", "", f"{_sentence(command.description or name)}", ""]
        usage = command.format_usage().removeprefix("usage: ").rstrip()
        lines += ["```text", re.sub(r"\s*\n\s*", "\n    ", usage), "```", ""]
        lines += ["| argument | meaning |", "|---|---|", *_arguments(command), ""]
    return "\n".join(lines)


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _commands(top: argparse.ArgumentParser) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    for action in top._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.items()


def _arguments(command: argparse.ArgumentParser) -> Iterator[str]:
    for action in command._actions:
        if isinstance(action, argparse._HelpAction):
            continue
        names = ", ".join(f"`{flag}`" for flag in action.option_strings)
        metavar = action.metavar or action.dest.upper()
        shown = names or f"`{metavar if isinstance(metavar, str) else ' '.join(metavar)}`"
        if action.choices:
            shown += f" ({', '.join(map(str, action.choices))})"
        yield f"| {_cell(shown)} | {_cell(action.help or '')} |"


def _cell(text: str) -> str:
    return text.replace("\n", " ").replace("|", "\\|")
