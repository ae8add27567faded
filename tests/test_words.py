"""Docstrings of the server say what the code does, in plain words."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pointbrush

ROOT = Path(pointbrush.__file__).parent
RIDDLE = re.compile(r"\W*(what|who|whose|which|where|those|how|why|when)\b", re.IGNORECASE)
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
