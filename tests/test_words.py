"""Docstrings of the server and comments of the page say what the code does, in plain words."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pointbrush
from docs.words import comments, complaints, complaints_of_comments, counts

ROOT = Path(pointbrush.__file__).parent
PAGE = Path(__file__).parents[1] / "webxr_client" / "src"
RIDDLE = re.compile(r"\W*(what|who|whose|which|where|those|how|why|when)\b", re.IGNORECASE)
RIDDLE_BEHIND = re.compile(
    r"\W*(return|yield|tell|say|give|show|list|find|choose|note|know|record|take|answer|measure|learn)s?"
    r"\s+(?:out\s+)?(what|who|whose|whom|which|how|where|why|when)\b",
    re.IGNORECASE,
)
COMMENT = re.compile(r"/\*\*[\s*]*([^\n]*)|(?:^|\n)[ \t]*//([^\n]*(?:\n[ \t]*//[^\n]*)*)")
TEXT = re.compile(r"""['"`]([^'"`\n]*)['"`]|>([^<>{}=;()]*)<""")
VALUE = re.compile(r"\$\{[^{}]*\}")
PRONOUN = re.compile(
    r"\b(what|who|whose|whom|those|nobody|somebody|someone|everybody|whoever|whatever)\b",
    re.IGNORECASE,
)
PERSON = re.compile(r"\b(he|his|him|himself)\b", re.IGNORECASE)


def test_no_docstring_opens_with_a_riddle_and_a_person_is_they() -> None:
    found = []
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            # Docstrings of attributes stand as expressions, like all others.
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                text = str(node.value.value)
                if RIDDLE.match(text) or PERSON.search(text):
                    found.append((path.relative_to(ROOT).as_posix(), text.splitlines()[0]))
    assert found == []


def test_no_docstring_hides_a_riddle_behind_a_verb_and_nothing_returns_none() -> None:
    found = []
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            text, returns = ast.get_docstring(node) or "", getattr(node, "returns", None)
            nothing = isinstance(returns, ast.Constant) and returns.value is None
            if RIDDLE_BEHIND.match(text) or (nothing and text.startswith("Return")):
                found.append((path.relative_to(ROOT).as_posix(), text.splitlines()[0]))
    assert found == []


def test_no_comment_of_the_page_opens_with_a_riddle() -> None:
    found = []
    for path in PAGE.rglob("*.ts*"):
        for comment in COMMENT.finditer(path.read_text()):
            text = comment[1] or comment[2]
            if RIDDLE.match(text or ""):
                found.append((path.relative_to(PAGE).as_posix(), text.splitlines()[0]))
    assert found == []


def test_pronouns_of_prose_are_counted_and_code_is_left_out() -> None:
    prose = "Nobody knows <!-- who --> what `who` does: see [those](whom.md).\n"
    assert counts(prose) == (3, 6)
    assert counts("```sh\nwho\n```\n~~~\nwhat\n~~~\nThe server answers.\n") == (0, 3)


def test_a_page_of_many_pronouns_is_named_and_many_pages_of_some_too() -> None:
    plain = "The server keeps the newest frame. " * 100
    assert complaints({"a.md": plain}) == []
    (line,) = complaints({"a.md": plain * 9, "b.md": plain + "who " * 6})
    assert line.startswith("b.md: expected at most 8 free pronouns per 1,000 words, got 9.9 (6)")
    (line,) = complaints(dict.fromkeys("abc", plain + "those " * 3))
    assert line.startswith("all pages: expected at most 4 free pronouns")


def test_comments_of_a_package_are_counted_and_its_code_is_not(tmp_path: Path) -> None:
    module, component = tmp_path / "module.py", tmp_path / "component.ts"
    module.write_text('who = "what"  # nobody\ndef f():\n    """Whoever."""\n')
    component.write_text("/** Those. */\nconst what = 'https://who'; // nobody\n")
    assert [counts(comments(path)) for path in (module, component)] == [(2, 2), (2, 2)]
    plain = "The server keeps the newest frame. " * 100
    assert complaints_of_comments({"server/pointbrush/a": plain}) == []
    (line,) = complaints_of_comments({"server/pointbrush/a": plain + "who " * 3})
    assert line.startswith("comments of server/pointbrush/a: expected at most 3 free pronouns")


def test_no_text_of_the_page_has_a_free_pronoun() -> None:
    found = []
    for path in PAGE.rglob("*.ts*"):
        if ".test." in path.name or path.name == "own-keys.ts":  # it has the former words
            continue
        code = VALUE.sub("_", COMMENT.sub("\n", path.read_text()))
        for text in TEXT.finditer(code):
            words = " ".join((text[1] or text[2] or "").split())
            if " " in words and PRONOUN.search(words):
                found.append((path.relative_to(PAGE).as_posix(), words))
    assert found == []
