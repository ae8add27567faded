"""LAS and LAZ in, labels made, out: everything the source had is there."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

from pointbrush.workspace import Workspace
from tests.serving import settings_in
from tests.waiting import PATIENCE

SHARED = Path(__file__).parents[3] / "shared" / "formats" / "las"
OURS = ("label", "category", "instance")
REAL = (
    "PDAL__autzen_trim.laz", "PDAL__extrabytes.las",
    "PDAL__lots_of_vlr.las", "PDAL__utm17.las", "laspy__1_4_w_evlr.las", "laspy__1_4_w_evlr.laz",
    "laspy__extra.laz", "laspy__fullwave.laz", "laspy__simple.copc.laz", "laspy__simple1_1.las",
    "laspy__unregistered_extra_bytes.las", "laspy__vegetation_1_3.las",
    "loaders.gl__pdrf10-1.4.laz", "loaders.gl__pdrf5-1.3.laz", "loaders.gl__pdrf7-v4-1.4.las",
)  # fmt: skip


def through(tmp_path: Path, source: Path, kind: str) -> laspy.LasData:
    """Import a file, label some points, export it."""
    with closing(Workspace(settings_in(tmp_path))) as workspace:
        job = workspace.runner.wait(workspace.imports.begin([source]).id, PATIENCE)
        assert job.state == "done", job.error
        assert job.result is not None
        sequence = job.result["sequence"]
        label = workspace.labels.create_label(sequence, "ann", name="roof", category="Building")
        array = workspace.annotations.read(sequence, 0)[0].copy()
        array[: len(array) // 2] = label.id
        workspace.annotations.put(sequence, 0, array, author="ann")
        workspace.export(sequence, kind, tmp_path / "out")
    found = laspy.read(tmp_path / "out" / f"000000.{kind}")
    assert np.array_equal(np.asarray(found["label"]), array)
    return found


def same(found: laspy.LasData, source: laspy.LasData) -> None:
    assert str(found.header.version) == str(source.header.version)
    assert found.header.point_format.id == source.header.point_format.id
    assert found.header.scales.tolist() == source.header.scales.tolist()
    assert found.header.offsets.tolist() == source.header.offsets.tolist()
    for vlrs, theirs in (
        (found.header.vlrs, source.header.vlrs),
        (found.header.evlrs or [], source.header.evlrs or []),
    ):
        kept = [content(vlr) for vlr in vlrs]
        for vlr in theirs:
            # Records on how points were packed are made anew; extra bytes have ours beside.
            if (vlr.user_id, vlr.record_id) != ("LASF_Spec", 4) and vlr.user_id not in (
                "copc", "laszip encoded",
            ):  # fmt: skip
                assert content(vlr) in kept
    for name in source.point_format.dimension_names:
        if name in OURS:
            continue
        expected = np.asarray(source[name])
        if name == "ExtraBytes":
            got = [np.asarray(found[f"extra_byte_{i}"]) for i in range(expected.shape[1])]
            np.testing.assert_array_equal(np.stack(got, axis=1), expected)
        else:
            np.testing.assert_array_equal(np.asarray(found[name]), expected, err_msg=name)


def content(vlr: Any) -> tuple[str, int, bytes]:
    return vlr.user_id, vlr.record_id, vlr.record_data_bytes()


@pytest.mark.parametrize("name", REAL)
def test_real_files_keep_what_they_had(tmp_path: Path, name: str) -> None:
    source = SHARED / name
    if not source.is_file():
        pytest.skip("../shared is absent")
    kind = "laz" if name.endswith("laz") else "las"
    same(through(tmp_path, source, kind), laspy.read(source))


@pytest.mark.parametrize("kind", ["las", "laz"])
@pytest.mark.parametrize("form", [0, 3, 6, 8])
def test_fields_flags_and_colours_of_16_bits_are_kept(tmp_path: Path, form: int, kind: str) -> None:
    rng = np.random.default_rng(3)
    header = laspy.LasHeader(version="1.4", point_format=form)
    header.scales, header.offsets = [0.01, 0.02, 0.001], [500_000, 4_000_000, -10]
    header.add_extra_dims(
        [
            laspy.ExtraBytesParams("height above ground", np.float32),
            laspy.ExtraBytesParams("category", np.uint8),
            laspy.ExtraBytesParams("normal", "3f4"),
        ]
    )
    header.vlrs.append(laspy.VLR("pointbrush", 7, "a note", b"kept as it is"))
    las = laspy.LasData(header)
    count = 400
    las.X, las.Y, las.Z = rng.integers(-100_000, 100_000, (3, count), dtype=np.int32)
    for name in las.point_format.dimension_names:
        dimension = las.point_format.dimension_by_name(name)
        if name in "XYZ":
            continue
        shape = (count, dimension.num_elements) if dimension.num_elements > 1 else count
        if dimension.kind == laspy.DimensionKind.FloatingPoint:
            las[name] = rng.normal(size=shape)
        else:
            highest = 1 << min(dimension.num_bits // dimension.num_elements, 15)
            las[name] = rng.integers(0, highest, shape)
    las.write(tmp_path / f"a.{kind}")
    found = through(tmp_path, tmp_path / f"a.{kind}", kind)
    source = laspy.read(tmp_path / f"a.{kind}")
    same(found, source)
    # A field of theirs that is called as ours is not overwritten.
    np.testing.assert_array_equal(found["category"], source["category"])
    assert set(np.unique(found["pointbrush_category"]).tolist()) == {0, 1}


def test_the_classification_is_labels_when_asked_for(tmp_path: Path) -> None:
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales = [0.001] * 3
    las = laspy.LasData(header)
    las.X = las.Y = las.Z = np.arange(100, dtype=np.int32)
    las.classification = np.repeat([1, 2, 6, 64], 25).astype(np.uint8)
    las.write(tmp_path / "a.las")
    with closing(Workspace(settings_in(tmp_path))) as workspace:
        job = workspace.runner.wait(workspace.imports.begin([tmp_path / "a.las"]).id, PATIENCE)
        assert job.result is not None
        sequence = job.result["sequence"]
        assert workspace.labels.palette(sequence) == []
        work = workspace.imports.begin_labels(sequence, tmp_path / "a.las", "ann", format="las")
        done = workspace.runner.wait(work.id, PATIENCE)
        assert done.state == "done", done.error
        names = {label.id: label.name for label in workspace.labels.palette(sequence)} | {0: ""}
        found = [names[n] for n in workspace.annotations.read(sequence, 0)[0].tolist()]
    assert found == [""] * 25 + ["Ground"] * 25 + ["Building"] * 25 + ["class 64"] * 25


def test_tree_numbers_without_classes_stay_as_they_are(tmp_path: Path) -> None:
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.add_extra_dims([laspy.ExtraBytesParams("treeID", "int32")])
    las = laspy.LasData(header)
    las.x = las.y = las.z = np.arange(30.0)
    las.treeID = np.arange(30) % 4 - 1
    las.write(tmp_path / "trees.las")
    found = through(tmp_path, tmp_path / "trees.las", "las")
    assert np.array_equal(np.asarray(found["treeID"]), np.asarray(las["treeID"]))
