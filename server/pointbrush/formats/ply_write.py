"""PLY files, written in binary."""

from __future__ import annotations

from typing import BinaryIO

from pointbrush.formats.ply import NAMES
from pointbrush.formats.table import Table


def write_ply(out: BinaryIO, table: Table, comments: tuple[str, ...] = ()) -> None:
    """Write a table as the vertices of a binary little-endian PLY."""
    types, blocks = table.rows()
    lines = ["ply", "format binary_little_endian 1.0"]
    lines += [f"comment {comment}" for comment in comments]
    lines.append(f"element vertex {table.count}")
    lines += [f"property {NAMES[kind.str[1:]]} {name}" for name, kind in types.items()]
    out.write("\n".join([*lines, "end_header", ""]).encode("ascii"))
    for rows in blocks:
        out.write(rows.tobytes())
