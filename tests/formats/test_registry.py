"""The registry: names, endings, and plug-ins."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats.registry import format_by_name, format_named, format_names

PLUGIN = """
import numpy as np
from pointbrush.formats import Format
from pointbrush.frame import PointFrame

def read_scan(path, options):
    yield PointFrame(xyz=np.full((1, 3), 5.0))

SCAN = Format("scan", (".scan",), read_scan, "Scanner X")
"""
ENTRY_POINTS = """[pointbrush.formats]
absent = no_such_package:READER
wrong = scanner_plugin:read_scan
scan = scanner_plugin:SCAN
"""


@pytest.mark.parametrize("first", ["pointbrush.formats", "scanner_plugin"])
def test_plug_ins_add_formats_and_broken_ones_do_no_harm(tmp_path, first):
    (tmp_path / "scanner_plugin.py").write_text(PLUGIN)
    (tmp_path / "scanner_plugin-1.dist-info").mkdir()
    (tmp_path / "scanner_plugin-1.dist-info" / "entry_points.txt").write_text(ENTRY_POINTS)
    (tmp_path / "scanner_plugin-1.dist-info" / "METADATA").write_text("Name: scanner_plugin")
    (tmp_path / "a.scan").write_text("scan")
    script = f"import {first}; from pointbrush.formats import read; print(*read('a.scan'))"
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "PointFrame" in done.stdout
    assert "absent could not be loaded" in done.stderr
    assert "wrong: expected a Format" in done.stderr


def test_names_and_aliases():
    assert {"ply", "xyz", "laz", "kinect"} <= set(format_names())
    assert format_named("LAZ").name == "las"
    assert format_named(".xyz").name == "text"
    assert format_named("semantickitti").name == "kitti"
    with pytest.raises(BadInputError, match=r"format: expected one of ply, pcd, .*, got 'mp3'"):
        format_named("mp3")


ENDINGS = [("A.PLY", "ply"), ("a.copc.laz", "las"), ("ply", None), ("a.db3", "rosbag2")]


@pytest.mark.parametrize(("name", "expected"), ENDINGS)
def test_the_format_is_told_by_the_ending(tmp_path, name, expected):
    found = format_by_name(tmp_path / name)
    assert (found.name if found else None) == expected
