"""Recordings on disk, and the cut that the project carries."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats import read
from pointbrush.frame import PointFrame
from pointbrush.samples import generate, write
from pointbrush.samples.__main__ import main
from pointbrush.samples.crowd import CrowdOptions
from pointbrush.samples.generating import decimate, picture
from pointbrush.samples.jugglers import JugglingOptions
from pointbrush.samples.tabletop import TabletopOptions
from pointbrush.samples.walkers import WalkingOptions

DATA = Path(__file__).parent.parent.parent / "data" / "juggling"


def test_written_frames_are_read_back_unlabelled(tmp_path: Path) -> None:
    recording = generate("tabletop", frames=2, things=2)
    paths = write(recording, tmp_path / "out", step=4)
    for i, (path, frame) in enumerate(zip(paths, read(tmp_path / "out"), strict=True)):
        thin, truth = decimate(recording.frame(i), recording.truth[i], 4)
        np.testing.assert_array_equal(frame.xyz, thin.xyz)
        np.testing.assert_array_equal(frame.rgb, thin.rgb)
        assert frame.label is None
        with np.load(path) as archive:
            np.testing.assert_array_equal(archive["truth"], truth)
    about = json.loads((tmp_path / "out" / "recording.json").read_text())
    assert [label["name"] for label in about["labels"]] == ["mug", "carton"]
    assert len(about["poses"]["1"]) == 2


def test_decimated_pixels_fit_their_camera() -> None:
    recording = generate(frames=1)
    frame, truth = decimate(recording.frame(0), recording.truth[0], 2)
    assert frame.camera is not None
    assert frame.pixel is not None
    assert (frame.camera.width, frame.camera.height) == (256, 212)
    assert len(truth) == len(frame)
    x, _, z = frame.xyz.T
    np.testing.assert_allclose(
        x / z * frame.camera.fx + frame.camera.cx, frame.pixel % 256, atol=1e-3
    )


def test_a_folder_with_frames_is_not_overwritten(tmp_path: Path) -> None:
    recording = generate("tabletop", frames=1, things=1)
    write(recording, tmp_path, step=8)
    with pytest.raises(BadInputError, match="expected a folder without"):
        write(recording, tmp_path, step=8)
    with pytest.raises(BadInputError, match="step"):
        write(recording, tmp_path / "new", step=0)


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "cut")
    arguments = ["--frames", "1", "--step", "4", "--out", out, "--option", "pins=3"]
    assert main(arguments) == 0
    assert "1 frames of Juggling" in capsys.readouterr().out
    assert main(arguments) == 1
    assert "expected a folder without" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["--out", out, "--option", "pins"])


def test_the_cut_is_small_and_is_what_the_generator_makes() -> None:
    files = sorted(DATA.glob("*.npz"))
    assert len(files) == 6
    assert sum(path.stat().st_size for path in DATA.iterdir()) < 5_000_000
    recording = generate("juggling", seed=0, frames=6)
    for i, path in enumerate(files):
        frame, truth = decimate(recording.frame(i), recording.truth[i], 2)
        with np.load(path) as archive:
            np.testing.assert_array_equal(archive["xyz"], frame.xyz)
            np.testing.assert_array_equal(archive["rgb"], frame.rgb)
            np.testing.assert_array_equal(archive["truth"], truth)


def test_a_picture_shows_the_colours_where_there_is_depth() -> None:
    frame = generate("walking", frames=1).frame(0)
    pixels = np.asarray(picture(frame)).reshape(-1, 3)
    np.testing.assert_array_equal(pixels[frame.pixel], frame.rgb)
    assert (np.delete(pixels, frame.pixel, axis=0) == 0).all()
    with pytest.raises(BadInputError, match="camera"):
        picture(PointFrame(frame.xyz))


@pytest.mark.parametrize(
    "options", [CrowdOptions, JugglingOptions, TabletopOptions, WalkingOptions]
)
def test_every_option_is_documented(options: type) -> None:
    text = (DATA.parents[1] / "docs" / "samples.md").read_text()
    for option in dataclasses.fields(options):
        assert f"`{option.name}`" in text
