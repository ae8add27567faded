"""Every array from outside goes through the validator in ``npz``; other loaders are listed here."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import pointbrush

ROOT = Path(pointbrush.__file__).parent
LOADERS = {"load", "frombuffer", "fromfile", "fromstring", "memmap", "open_memmap", "read_array"}
"""Functions of NumPy that make arrays of bytes or files."""

ALLOWED = {
    # Readers of imported files: they run in import processes, which may die.
    "formats/",
    # The client: arrays of a server that its user has chosen.
    "client/",
    # Uploads of one array: type, shape and number of bytes are compared with the header before.
    "web/npy.py:_data",
    # Numbers of points from outside: compared with the frame's number of points after.
    "ranges.py:numbers_of",
    # Chunks and columns of imported recordings, written by the server and kept with checksums.
    "sequences/octree/",
    "sequences/storage/source_fields.py:_arrays",
    # Mapped files whose pages are looked at, not read.
    "sequences/storage/frame_files.py:MappedFiles._look",
    "sequences/storage/residence.py:",
    # Values in the label database, written by the server.
    "labels/packing.py:",
    "labels/state.py:decode_points",
    # Layers that the server has packed, in its memory or from its worker processes.
    "work/annotate/layers.py:Packed.values",
    # Bytes that are written or sent, not read.
    "classify/classifier.py:to_file",
    "classify/models.py:HttpModel.scores",
    # Weights that are part of the package.
    "selection/objects/weights.py:load_weights",
}
"""Functions, files (``file:``) and folders that need no validator, each with the reason."""


def loaders(source: str) -> Iterator[tuple[str, str]]:
    """Yield the function and the name of each use of a loader in a module, called or handed on."""
    tree = ast.parse(source)
    names = dict(_imported(tree))

    def full(node: ast.AST) -> str:
        if isinstance(node, ast.Attribute):
            return f"{full(node.value)}.{node.attr}"
        return names.get(node.id, "") if isinstance(node, ast.Name) else ""

    def walk(node: ast.AST, place: str) -> Iterator[tuple[str, str]]:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            place = f"{place}.{node.name}".lstrip(".")
        name = full(node)
        if name.startswith("numpy.") and name.rpartition(".")[2] in LOADERS:
            yield place, name
        for child in ast.iter_child_nodes(node):
            yield from walk(child, place)

    return walk(tree, "")


def allowed(place: str) -> set[str]:
    """Return the entries of ALLOWED that name a place."""
    file = place.partition(":")[0]
    folders = {f"{parent.as_posix()}/" for parent in Path(file).parents}
    return {place, f"{file}:", *folders} & ALLOWED


def _imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for each in node.names:
                top = each.name.partition(".")[0]
                yield (each.asname, each.name) if each.asname else (top, top)
        elif isinstance(node, ast.ImportFrom):
            for each in node.names:
                yield each.asname or each.name, f"{node.module}.{each.name}"


@pytest.mark.parametrize(
    "source",
    [
        "import numpy as np\ndef read(data):\n    return np.load(data)",
        "import numpy\ndef read(data):\n    return numpy.frombuffer(data)",
        "def read(data):\n    from numpy import fromfile as part\n    return part(data)",
        "import numpy as np\ndef read(data):\n    return map(np.load, data)",
        "import numpy as np\ndef read(data):\n    return np.lib.format.read_array(data)",
        "from numpy.lib import format\ndef read(data):\n    return format.read_array(data)",
    ],
)
def test_a_loader_is_found_by_any_name(source: str) -> None:
    assert [place for place, _ in loaders(source)] == ["read"]


def test_a_module_of_our_own_may_have_the_name_of_a_loader() -> None:
    source = "import json\nfrom pointbrush.x import read_array\nread_array(json.load(None))"
    assert not list(loaders(source))


def test_no_loader_bypasses_the_validator() -> None:
    found = {
        f"{path.relative_to(ROOT).as_posix()}:{place}": name
        for path in sorted(ROOT.rglob("*.py"))
        for place, name in loaders(path.read_text(encoding="utf-8"))
    }
    others = {place: name for place, name in found.items() if not allowed(place)}
    assert not others, "read arrays by npz.read_npz and npz.checked, or give a reason in ALLOWED"
    unused = ALLOWED - {entry for place in found for entry in allowed(place)}
    assert not unused, "these have no loader any more"
