"""Depth images: what goes as one, in which order, and how near it is to the stored points."""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pointbrush.frame import DepthCamera, PointFrame
from pointbrush.sequences import Manifest, RecordingInfo, Sequence, import_frames, open_sequence
from pointbrush.sequences.depth.finding import find_lattice
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.storage.manifest import encode_manifest
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.camera import find_lens
from tests.depth_camera import FOCAL, HEIGHT, WIDTH, depth_camera
from tests.sequences.depth_decoder import decode_depth, unproject


def put(frames: list[PointFrame], path: Path) -> Sequence:
    import_frames(frames, path, RecordingInfo("s", "s", 30.0))
    return open_sequence(path)


def lattice_of(sequence: Sequence) -> Lattice:
    assert sequence.manifest.lattice is not None
    return sequence.manifest.lattice


def chunks_of(sequence: Sequence, frame: int) -> list[bytes]:
    stored = sequence[frame]
    return [stored.depth(i, i + 1).tobytes() for i in range(len(stored.chunks))]


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Sequence:
    return put([depth_camera(0), depth_camera(1)], tmp_path_factory.mktemp("depth") / "s")


def test_every_point_is_its_pixel_and_depth_within_the_manifests_error(sequence: Sequence) -> None:
    lattice, manifest = lattice_of(sequence), sequence.manifest
    for frame in range(2):
        stored, source = sequence[frame], depth_camera(frame)
        pixels, _ = decode_depth(lattice, chunks_of(sequence, frame))
        off = np.abs(unproject(lattice, pixels.pixel, pixels.depth) - stored.xyz)
        assert off.max() <= manifest.position_error <= 0.0005
        assert np.array_equal(stored.source_xyz(), source.xyz)


def test_a_prefix_is_a_smaller_image(sequence: Sequence) -> None:
    lattice, chunks = lattice_of(sequence), chunks_of(sequence, 0)
    for stop, band in enumerate(lattice.bands, 1):
        pixels, _ = decode_depth(lattice, chunks[:stop])
        rows, columns = np.divmod(pixels.pixel, lattice.width)
        assert not (rows % band.step).any()
        assert not (columns % band.step).any()
        assert len(pixels.pixel) == int(sequence[0].chunk_table["count"][:stop].sum())


def test_pictures_show_the_colours_within_the_stated_error(sequence: Sequence) -> None:
    lattice = lattice_of(sequence)
    pixels, pictures = decode_depth(lattice, chunks_of(sequence, 0))
    shown = np.asarray(Image.open(io.BytesIO(pictures[1])).convert("RGB")).reshape(-1, 3)
    rgb = sequence[0].rgb
    assert rgb is not None
    off = shown[pixels.pixel].astype(float) - rgb
    assert np.sqrt((off**2).mean()) <= sequence.manifest.color_error <= 6.0


def test_a_depth_image_keeps_all_its_pixels(tmp_path: Path) -> None:
    frame = depth_camera(0)
    seen = np.flatnonzero(np.arange(len(frame)) % WIDTH > 20)
    told = replace(
        frame,
        xyz=frame.xyz[seen],
        rgb=None,
        camera=DepthCamera(WIDTH, HEIGHT, FOCAL, FOCAL, 64, 53),
        pixel=seen.astype(np.uint32),
    )
    sequence = put([told], tmp_path / "s")
    lattice = lattice_of(sequence)
    assert (lattice.width, lattice.height) == (WIDTH, HEIGHT)
    pixels, pictures = decode_depth(lattice, chunks_of(sequence, 0))
    assert np.array_equal(sequence[0].pixel, pixels.pixel)
    assert pictures == {}


def test_a_whole_image_has_all_its_columns_though_every_so_many_points_are_of_few() -> None:
    v, u = np.mgrid[0:424, 0:512].reshape(2, -1)
    depth = 2.0 + 0.3 * np.sin(u / 60) * np.cos(v / 45)
    xyz = np.column_stack([(u - 256) * depth / 365, (v - 212) * depth / 365, depth])
    lattice = find_lattice(
        PointFrame(xyz.astype(np.float32)), xyz.astype(np.float32), np.zeros(3), 2.0**-10
    )
    assert lattice is not None
    assert lattice.pitch == pytest.approx((1 / 365, 1 / 365))
    assert 512 < lattice.width < 570


def test_colours_that_are_noise_are_imported_too(tmp_path: Path) -> None:
    v, u = np.mgrid[0:212, 0:256].reshape(2, -1)
    depth = 2.0 + 0.3 * np.sin(u / 30) * np.cos(v / 22)
    xyz = np.column_stack([(u - 128) * depth / 182, (v - 106) * depth / 182, depth])
    noise = np.random.default_rng(0).integers(0, 256, xyz.shape).astype(np.uint8)
    sequence = put([PointFrame(xyz.astype(np.float32), rgb=noise)], tmp_path / "s")
    rgb = sequence[0].rgb
    assert sequence[0].depth_ends is not None
    assert 0 < sequence.manifest.color_error <= 6.0
    assert rgb is not None
    assert np.array_equal(sequence[0].to_source(rgb), noise)


@pytest.mark.parametrize("how", ["turned", "scattered", "with intensity"])
def test_other_clouds_go_as_points(tmp_path: Path, how: str) -> None:
    frame = depth_camera(0)
    if how == "turned":
        turn = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]], np.float32)
        frame = replace(frame, xyz=frame.xyz @ turn)
    elif how == "scattered":
        rng = np.random.default_rng(0)
        frame = replace(frame, xyz=frame.xyz + rng.normal(0, 0.001, frame.xyz.shape).astype("f4"))
    else:
        frame = replace(frame, intensity=np.ones(len(frame), np.float32))
    sequence = put([frame], tmp_path / "s")
    assert sequence.manifest.lattice is None
    assert sequence[0].depth_ends is None
    assert sequence.manifest.color_error == 0


def test_a_lattice_is_kept_by_the_manifest_as_it_is(sequence: Sequence) -> None:
    again: Manifest = open_sequence(sequence.path).manifest
    assert again.lattice == sequence.manifest.lattice
    assert lattice_of(sequence).bands[0].level == 0
    assert all(a.level <= b.level for a, b in pairwise(lattice_of(sequence).bands))


def test_images_of_an_older_format_go_as_points(tmp_path: Path) -> None:
    made = put([depth_camera(0)], tmp_path / "s")
    older = replace(made.manifest, depth_format=1)
    (made.path / "manifest.json").write_bytes(encode_manifest(older))
    opened = open_sequence(made.path)
    assert opened.manifest.depth_lattice is None
    assert opened[0].depth_ends is None
    assert opened[0].lattice == made.manifest.lattice  # tracking still looks along its rays
    assert opened[0].wire(0, 1) == made[0].wire(0, 1)


def test_tracking_takes_the_lattice_from_the_manifest(sequence: Sequence) -> None:
    lattice, stored = lattice_of(sequence), sequence[0]
    lens = find_lens(stored, options=TrackerOptions())
    assert lens is not None
    assert lens.pitch == lattice.pitch
    pixels, _ = decode_depth(lattice, chunks_of(sequence, 0))
    margin = TrackerOptions().lens.margin_px
    rows, columns = np.divmod(lens.cells(stored.xyz, TrackerOptions().lens).cell, lens.shape[1])
    assert np.array_equal((rows - margin) * lattice.width + columns - margin, pixels.pixel)
