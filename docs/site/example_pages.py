"""Pages of docs/examples: a script, notebook or package with its opening words and its code."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"
LINK = re.compile(r"\]\(((?:\.\./)*)examples/(\w+)(?:\.py|\.ipynb|/)?\)")
"""A link to an example's file or folder, as it stands in docs/."""
KINDS = {".py": "python", ".toml": "toml"}


def pages() -> dict[str, str]:
    """Return the pages by their places."""
    found = sorted(path for path in EXAMPLES.iterdir() if not path.name.startswith((".", "_")))
    return {f"examples/{path.stem}.md": "\n".join(_page(path)) for path in found}


def linked(text: str) -> str:
    """Let links to examples lead to their pages."""
    return LINK.sub(r"](\1examples/\2.md)", text)


def _page(path: Path) -> Iterator[str]:
    yield from (f"# Example: {path.name}", "")
    if path.suffix == ".ipynb":
        yield from _notebook(path)
        return
    files = [path] if path.is_file() else sorted(path.glob("*.*"))
    for file in files:
        text = file.read_text(encoding="utf-8")
        if file.suffix == ".py":
            about = ast.get_docstring(ast.parse(text)) or ""
            text = text.split('"""', 2)[-1].strip() if about else text
            yield from (about, "")
        if len(files) > 1:
            yield from (f"## {file.name}", "")
        yield from (f"```{KINDS.get(file.suffix, 'text')}", text.rstrip(), "```", "")


def _notebook(path: Path) -> Iterator[str]:
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code":
            yield from ("```python", text, "```", "")
        else:
            # The page has a title already.
            yield from (re.sub(r"^# ", "## ", text), "")
