"""Paths that a caller over the network may name: nothing is told of what lies outside."""

from __future__ import annotations

from pathlib import Path

import pytest

from pointbrush.errors import ForbiddenError, NotFoundError
from pointbrush.formats import Limits, open_source
from pointbrush.formats.inside import allowed


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A folder that may be read, beside one that may not, with links from one to the other."""
    inside, outside = tmp_path / "inside", tmp_path / "outside"
    for folder in (inside, outside, inside / ".hidden"):
        folder.mkdir()
        (folder / "a.xyz").write_text("1 2 3\n")
    (inside / "b.xyz").write_text("1 2 3\n")
    (inside / ".secret.xyz").write_text("1 2 3\n")
    (inside / "out").symlink_to(outside)
    (inside / "file.xyz").symlink_to(outside / "a.xyz")
    (inside / "shown.xyz").symlink_to(inside / ".secret.xyz")
    (inside / "round").symlink_to(inside / "round")
    return inside


REFUSED = (
    "../outside/a.xyz", "../outside", "../outside/none", "..", "/etc/passwd", "/nonexistent/x",
    "out", "out/a.xyz", "out/none.xyz", "file.xyz", "shown.xyz", ".hidden", ".hidden/a.xyz",
    ".hidden/none", ".none", ".secret.xyz", "o*/a.xyz", "o*/none*", "*/a.xyz", "*/none", ".h*/*",
    "../out*/*", "**/a.xyz", "f*.xyz", "sub/../../outside/a.xyz",
)  # fmt: skip


@pytest.mark.parametrize("path", REFUSED)
def test_what_lies_or_leads_outside_is_refused_in_one_text(root: Path, path: str) -> None:
    with pytest.raises(ForbiddenError) as found:
        allowed(str(root / path), [root])
    with pytest.raises(ForbiddenError) as other:
        allowed("/somewhere/else", [root])
    assert str(found.value) == str(other.value)


@pytest.mark.parametrize("path", ["none", "none/deeper", "a.xyz/below", "n*", "x" * 300])
def test_what_is_missing_inside_is_not_found(root: Path, path: str) -> None:
    with pytest.raises(NotFoundError):
        allowed(str(root / path), [root])


def test_what_is_inside_is_found(root: Path) -> None:
    assert allowed(str(root / "a.xyz"), [root]) == [root / "a.xyz"]
    assert allowed(str(root / "out" / ".." / "b.xyz"), [root]) == [root / "b.xyz"]
    assert sorted(allowed(str(root / "[ab].xyz"), [root])) == [root / "a.xyz", root / "b.xyz"]
    assert allowed(str(root), [root]) == [root]


def test_no_roots_allow_nothing(root: Path) -> None:
    with pytest.raises(ForbiddenError):
        allowed(str(root / "a.xyz"), [])


def test_links_of_links_below_a_folder_are_followed_to_their_end(root: Path) -> None:
    (root / "one").mkdir()
    (root / "two").mkdir()
    (root / "one" / "next").symlink_to(root / "two")
    limits = Limits(roots=(root,))
    (root / "two" / "a.xyz").write_text("1 2 3\n")
    with open_source([root / "one"], limits=limits) as source:
        assert source.count == 1
    (root / "two" / "b.xyz").symlink_to(root.parent / "outside" / "a.xyz")
    with pytest.raises(ForbiddenError):
        open_source([root / "one"], limits=limits)
