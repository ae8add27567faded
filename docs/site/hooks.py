"""Pages of the site that are written from the program, and files above docs/."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import example_pages
import python_page
import rest_pages
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Navigation
from mkdocs.structure.pages import Page

from pointbrush.cli import parser

ROOT = Path(__file__).parents[2]
WIDE = (
    "conventions.md",
    "headset-devices.md",
    "options.md",
    "roles.md",
)
"""Pages of tables that take the room of the contents beside them."""
ABOVE = {
    "ARCHITECTURE.md": "explanation/architecture.md",
    "CHANGELOG.md": "reference/changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
"""Files above docs/ and their places in the site."""
PAGES: list[Page] = []
"""All pages, first the pages of the navigation in its order."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are no files of docs/."""
    pages = {place: above(name, place) for name, place in ABOVE.items()}
    pages |= rest_pages.pages() | python_page.pages() | example_pages.pages()
    for place, text in pages.items():
        files.append(File.generated(config, place, content=text))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, **_: object) -> str:
    """Complete the reference pages, and lead links to files to the pages of these files."""
    place = page.file.src_uri
    if place in WIDE:
        page.meta["hide"] = ["toc"]
    if words := config.extra["search_words"].get(place):
        page.meta["tags"] = words
    for name, target in ABOVE.items():
        markdown = re.sub(rf"\]\(((?:\.\./)*)\.\./{name}", rf"](\1{target}", markdown)
    return example_pages.linked(markdown) + WRITTEN.get(place, str)()


def on_nav(nav: Navigation, files: Files, **_: object) -> None:
    """Keep the pages for ``llms.txt``: first those of the navigation, in its order."""
    others = [file.page for file in files.documentation_pages() if file.page not in nav.pages]
    PAGES[:] = [*nav.pages, *others]


def on_post_build(config: MkDocsConfig) -> None:
    """List all pages in ``llms.txt``, with their first words."""
    lines = [f"# {config.site_name}", "", f"> {config.site_description}", ""]
    section = None
    for page in PAGES:
        group = page.ancestors[-1].title if page.ancestors else "Pages"
        if group != section:
            lines += ["", f"## {group}", ""]
            section = group
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


def above(name: str, place: str) -> str:
    """Return a page of the repository's top, with links that are right at ``place``."""
    text = (ROOT / name).read_text(encoding="utf-8")
    up = "../" * place.count("/")
    for other, target in ABOVE.items():
        text = text.replace(f"]({other}", f"]({up}{target}")
    return text.replace("](docs/", f"]({up}")


def command_line() -> str:
    """Return the reference of all commands, from the parser."""
    lines = [""]
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
        if isinstance(action, argparse._HelpAction) or action.help == argparse.SUPPRESS:
            continue
        names = ", ".join(f"`{flag}`" for flag in action.option_strings)
        metavar = action.metavar or action.dest.upper()
        shown = names or f"`{metavar if isinstance(metavar, str) else ' '.join(metavar)}`"
        if action.choices:
            shown += f" ({', '.join(map(str, action.choices))})"
        yield f"| {_cell(shown)} | {_cell(action.help or '')} |"


def _cell(text: str) -> str:
    return text.replace("\n", " ").replace("|", "\\|")


WRITTEN: dict[str, Callable[[], str]] = {
    "reference/cli.md": command_line,
    "reference/python.md": python_page.overview,
    "reference/rest.md": rest_pages.overview,
}
"""Pages whose files have the introduction alone, and the functions that write the rest."""
