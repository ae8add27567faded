"""Every file of other projects' test suites loads with the right count or says why not."""

from __future__ import annotations

import csv
import random

import pytest

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats import FORMATS, read
from tests.formats.mutated_files import changed

# What the reference parser read differently on purpose or by its own fault.
DIFFERENT = {
    "las/PDAL__1.2-with-color-clipped.las": "its last point is cut off",
    "e57/e57__las2e57_no_images_tag.e57": "the reference could not read its 153 points",
    "npy/PDAL__twodim.npy": "has no y and z",
    "text/PDAL__bunny_8.pts": "says 8 points and has 9",
}
COUNTED = ("ply/", "pcd/", "las/", "copc/", "misc_pyntcloud/", "e57/")
MUST_FAIL = {
    *("ply/assimp__empty.ply", "ply/PDAL__no_vertex.ply", "pcd/PDAL__missingheader.pcd"),
    *("ply/assimp__crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply", "text/PDAL__text.txt"),
    *("las/PDAL__garbage_nVariableLength.las", "las/PDAL__1.2-with-color-clipped.las"),
    *("pcd/pypcd4__ascii_invalid_header.pcd", "text/PDAL__utm17_3.txt"),
    "las/PDAL__simple-laszip-compressor-version-1.2r0.laz",
}


def test_every_file_loads_whole_or_says_why(shared):
    endings = tuple(ending for entry in FORMATS.values() for ending in entry.extensions)
    with (shared / "formats" / "MANIFEST.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    wrong, loaded = [], 0
    for row in rows:
        name = row["file"]
        try:
            frames = list(read(shared / "formats" / name))
        except (BadInputError, TooLargeError) as error:
            readable = name.endswith(endings) and row["status"] == "ok" and name not in DIFFERENT
            if "expected" not in str(error) or (readable and row["points"]):
                wrong.append(f"{name}: {error}")
            continue
        # Counts of the reference are with the missing pixels of PCD, without those of E57.
        missing = 0 if name.startswith("e57/") else sum(frame.dropped for frame in frames)
        got = sum(len(frame) for frame in frames) + missing
        loaded += 1
        if name in MUST_FAIL:
            wrong.append(f"{name}: loaded {got} points, but it is damaged")
        elif (
            name.startswith(COUNTED)
            and row["points"]
            and name not in DIFFERENT
            and got != int(row["points"])
        ):
            wrong.append(f"{name}: expected {row['points']} points, got {got}")
    assert not wrong, "\n".join(wrong)
    assert loaded > 120


@pytest.mark.parametrize("kind", ["ply", "pcd", "las", "npy", "text", "e57", "misc_pyntcloud"])
def test_half_a_file_never_does_worse_than_raise(shared, tmp_path, kind):
    """Cut anywhere, a file raises, or is text whose lines end where it was cut."""
    for path in sorted((shared / "formats" / kind).iterdir()):
        data = path.read_bytes()[:100_000]
        for part in (0.1, 0.5, 0.9):
            cut = tmp_path / path.name
            cut.write_bytes(data[: int(len(data) * part)])
            try:
                list(read(cut))
            except (BadInputError, TooLargeError) as error:
                assert path.name in str(error)  # noqa: PT017


def test_mutated_files_raise_errors_that_say_what_was_expected(shared, tmp_path):
    endings = {".ply", ".pcd", ".npy", ".npz", ".las", ".e57", ".txt", ".pts", ".xyz", ".csv"}
    files = sorted(path for path in (shared / "formats").rglob("*") if path.suffix in endings)
    rng = random.Random(7)
    for path in rng.choices([path for path in files if path.stat().st_size < 40_000], k=1200):
        copy = tmp_path / path.name
        copy.write_bytes(changed(path.read_bytes(), rng))
        try:
            list(read(copy))
        except (BadInputError, TooLargeError) as error:
            assert "expected" in str(error)  # noqa: PT017
