"""The documented examples work as documented."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from serving import TOKEN, add_sequence
from waiting import PATIENCE

from pointbrush.client import Client, Recording
from pointbrush.errors import PointbrushError
from pointbrush.samples import generate
from pointbrush.settings import Settings

ROOT = Path(__file__).parent.parent
EXAMPLES = ROOT / "docs" / "examples"
FRAMES = 4
THINNED = 8
"""One point of so many of the sample is kept: what examples do takes time by the point."""


@dataclass(frozen=True)
class Sample:
    """A server with a part of the sample recording, whose true labels are known."""

    url: str
    folder: Path
    truth: list[np.ndarray]

    def imported(self, client: Client, name: str) -> Recording:
        return client.import_files([self.folder], name=name)


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sample]:
    """One server, with both plug-ins, for all examples."""
    folder = tmp_path_factory.mktemp("examples")
    made = generate("juggling", seed=0, frames=FRAMES)
    (folder / "juggling").mkdir()
    for i in range(FRAMES):
        frame = made.frame(i)
        assert frame.rgb is not None
        arrays = {"xyz": frame.xyz[::THINNED], "rgb": frame.rgb[::THINNED]}
        np.savez(folder / "juggling" / f"{i:04}.npz", **arrays)
    plugins = folder / "plugins"
    plugins.mkdir()
    for name in ("format_plugin", "tracker_plugin"):
        install(name, plugins)
    server = subprocess.Popen(
        [sys.executable, "-m", "pointbrush.cli", "serve", "--port", "0", "--workers", "1"],
        env=os.environ
        | {
            "PYTHONPATH": str(plugins),
            "POINTBRUSH_IMPORT_ROOTS": str(folder),
            "POINTBRUSH_TOKEN": TOKEN,
            "POINTBRUSH_WORKSPACE": str(folder / "workspace"),
        },
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert server.stdout is not None
        url = re.findall(r"http://\S+?(?=/|$)", server.stdout.readline().strip())[0]
        yield Sample(url, folder / "juggling", [truth[::THINNED] for truth in made.truth])
    finally:
        server.terminate()
        server.communicate(timeout=PATIENCE)


def install(plugin: str, folder: Path) -> None:
    """Put a plug-in where Python finds it with its entry points, as pip does."""
    source = EXAMPLES / plugin
    project = tomllib.loads((source / "pyproject.toml").read_text())["project"]
    for module in source.glob("*.py"):
        shutil.copy(module, folder)
    about = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Name: {project['name']}\nVersion: {project['version']}\n")
    with (about / "entry_points.txt").open("w") as file:
        for group, entries in project["entry-points"].items():
            file.write(f"[{group}]\n")
            file.writelines(f"{name} = {value}\n" for name, value in entries.items())


def run(script: str, *arguments: object, **variables: str) -> str:
    done = subprocess.run(
        [sys.executable, EXAMPLES / script, *map(str, arguments)],
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_rest_example_runs_against_a_real_server(sample: Sample) -> None:
    told = run("label_over_rest.py", sample.url, TOKEN, sample.folder)
    assert "painted" in told
    assert f"frame {FRAMES - 1}: tracked" in told
    assert "export:" in told


def test_folders_are_imported_and_those_known_are_left_out(sample: Sample, tmp_path: Path) -> None:
    for name in ("monday", "tuesday"):
        (tmp_path / name).mkdir()
        np.save(tmp_path / name / "0.npy", np.ones((20, 3), np.float32))
    (tmp_path / "monday" / "labels").mkdir()
    np.full(20, 10, "<u4").tofile(tmp_path / "monday" / "labels" / "0.label")
    (tmp_path / "wrong").mkdir()
    (tmp_path / "wrong" / "0.npy").write_bytes(b"no array")
    told = run("bulk_import.py", sample.url, TOKEN, tmp_path)
    assert "monday: 1 frames as monday, 20 points labelled in 1 of them" in told
    assert "wrong: 0.npy" in told
    assert "2 are there already, 1 to import" in run("bulk_import.py", sample.url, TOKEN, tmp_path)
    with Client(sample.url, TOKEN) as client:
        assert client["tuesday"].label("car")


def test_a_model_labels_and_people_are_asked_where_it_is_unsure(sample: Sample) -> None:
    with Client(sample.url, TOKEN) as client:
        recording = sample.imported(client, "prelabel")
        told = run("prelabel.py", sample.url, TOKEN, recording.id)
        assert f"in {FRAMES} frames" in told
        person = recording.label("person")
        frame = recording.frames[1]
        assert (frame.annotation() == person.id).sum() > 1000
        assert (frame.annotation("provenance") == 3).all()
        asked = recording.review.counts()["review"]
        assert f"{asked} frames to correct" in told


def test_a_classifier_is_taught_where_it_doubts(sample: Sample, tmp_path: Path) -> None:
    with Client(sample.url, TOKEN) as client:
        recording = sample.imported(client, "example")
        palette = [recording.create_label(name).id for name in ("pins", "people", "room")]
        classes = np.array([palette[2], *[palette[0]] * 6, *[palette[1]] * 2], np.uint16)
        truth = tmp_path / "truth.npy"
        np.save(truth, classes[sample.truth[0]])
        told = run("by_example.py", sample.url, TOKEN, recording.id, truth, "--strokes", 6)
        assert float(re.findall(r"([\d.]+)% right", told)[0]) > 50
        assert (recording.frames[1].annotation("provenance") == 4).any()


def test_who_watches_puts_doubts_up_for_review(sample: Sample) -> None:
    with Client(sample.url, TOKEN) as client:
        recording = sample.imported(client, "live")
        scattered = recording.create_label("scattered")
        values = np.zeros(len(sample.truth[0]), np.uint16)
        values[:: len(values) // 60] = scattered.id  # of no object: no tracker can be sure of it
        command = [sys.executable, EXAMPLES / "live.py", sample.url, TOKEN, "live"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as watching:
            assert watching.stdout is not None
            assert watching.stdout.readline() == "watching live\n"
            recording.frames[0].annotate(values)
            recording.track([scattered.id], 0, 1, method="icp", progress=False)
            told = []
            while not told or not told[-1].startswith("tracking: done"):
                told.append(watching.stdout.readline())
                assert told[-1], "it goes on"
            watching.terminate()
        doubtful = [track for track in recording.tracks() if track.state in ("lost", "occluded")]
        assert "annotation of frame 0" in told[0]
        assert len(doubtful) == sum("scattered is" in line for line in told)
        assert recording.review.counts().get("review", 0) == len(doubtful)


def test_points_of_classes_are_counted_over_many_recordings(sample: Sample) -> None:
    with Client(sample.url, TOKEN) as client:
        for name in ("first", "second"):
            recording = sample.imported(client, name)
            label = recording.create_label("rare 1", category="rare")
            recording.annotate({0: (sample.truth[0] == 1) * label.id})
    for number in range(18):  # others, copied into the workspace
        settings = Settings(workspace=sample.folder.parent / "workspace")
        add_sequence(settings, f"other-{number}", frames=1, points=50)
    told = run("many_recordings.py", sample.url, TOKEN)
    assert int(told.split()[0]) >= 20
    count = 2 * int((sample.truth[0] == 1).sum())
    assert f"{count:,} rare, in 2 recordings" in told


def test_frames_are_a_dataset(sample: Sample, tmp_path: Path) -> None:
    with Client(sample.url, TOKEN) as client:
        recording = sample.imported(client, "dataset")
        label = recording.create_label("pin 1", category="pin")
        recording.frames[0].annotate(np.where(sample.truth[0] == 1, label.id, 0).astype(np.uint16))
    out = tmp_path / "juggling.zip"
    told = run("dataset.py", sample.url, TOKEN, recording.id, out)
    count = int((sample.truth[0] == 1).sum())
    assert told.startswith(f"{FRAMES} frames, {count:,} labelled points\n")
    assert f"{count:,} pin, class " in told
    module = importlib.util.spec_from_file_location("dataset", EXAMPLES / "dataset.py")
    assert module is not None
    assert module.loader is not None
    dataset = importlib.util.module_from_spec(module)
    module.loader.exec_module(dataset)
    frames = dataset.LabelledFrames(out, points=5000)
    batch = np.stack([frames[i]["xyz"] for i in range(len(frames))])
    assert batch.shape == (FRAMES, 5000, 3)
    assert {name: array.dtype for name, array in frames[0].items()} == {
        "xyz": np.float32, "rgb": np.float32, "label": np.int64
    }  # fmt: skip
    assert frames[0]["label"].max() == frames.classes["pin"]


def test_two_annotations_are_compared(sample: Sample, tmp_path: Path) -> None:
    with Client(sample.url, TOKEN) as client:
        both = [sample.imported(client, name) for name in ("by-ada", "by-grace")]
        for recording, last in zip(both, (9, 8), strict=True):
            label = recording.create_label("people")
            people = (sample.truth[2] >= 7) & (sample.truth[2] < last)
            recording.frames[2].annotate(np.where(people, label.id, 0).astype(np.uint16))
    told = run("agreement.py", sample.url, TOKEN, both[0].id, both[1].id, tmp_path / "report")
    assert "frame 2 differs most" in told
    made = {path.name for path in (tmp_path / "report").iterdir()}
    assert made == {"labels.csv", "worst.png", "by-ada.html", "by-grace.html"}


def test_the_notebook_runs(sample: Sample, monkeypatch: pytest.MonkeyPatch) -> None:
    with Client(sample.url, TOKEN) as client:
        recording = sample.imported(client, "notebook")
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.setenv("POINTBRUSH_SERVER", sample.url)
    monkeypatch.setenv("POINTBRUSH_TOKEN", TOKEN)
    monkeypatch.setenv("POINTBRUSH_RECORDING", recording.id)
    cells = json.loads((EXAMPLES / "explore.ipynb").read_text())["cells"]
    names: dict[str, Any] = {}
    for cell in cells:
        assert cell.get("outputs", []) == []
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    names["client"].close()
    assert [track.frame for track in names["tracks"]][-1] == FRAMES - 1
    assert (names["values"] == names["label"].id).sum() > 50
    names["plt"].close("all")


def test_the_plug_ins_read_a_format_and_track(sample: Sample, tmp_path: Path) -> None:
    scans = tmp_path / "scans"
    scans.mkdir()
    for i in range(3):
        metres = np.full((16, 360), 10, "<f4")
        metres[4:12, 100 + i : 112 + i] = 4  # a post that goes round
        metres[0] = 0
        content = b"RGRID" + struct.pack("<HH", *metres.shape) + metres.tobytes()
        (scans / f"{i}.rgrid").write_bytes(content)
    with Client(sample.url, TOKEN) as client:
        recording = client.import_files([scans])
        assert recording.manifest.points == (15 * 360,) * 3
        post = np.zeros((15, 360), np.uint16)
        label = recording.create_label("post")
        post[3:11, 100:112] = label.id
        recording.frames[0].annotate(post.ravel())
        recording.track([label.id], 0, 2, method="centroid", progress=False)
        found = (recording.frames[2].annotation() == label.id).reshape(15, 360)
        assert found[3:11, 102:112].all()
        assert found.sum() <= 8 * 12
        (scans / "2.rgrid").write_bytes(content[:-1])
        with pytest.raises(PointbrushError, match=r"2\.rgrid: expected 23049 bytes, got 23048"):
            client.import_files([scans])


def documented(page: str, heading: str) -> dict[str, str]:
    """Language → the code of that language under a heading of a page of ``docs/``."""
    text = (ROOT / "docs" / page).read_text()
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
    return dict(re.findall(r"```(\w+)\n(.*?)```", section, re.DOTALL))


USE = """
import numpy as np
from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames, open_sequence
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pathlib import Path

xyz = np.random.default_rng(0).uniform(1, 2, (500, 3)).astype(np.float32)
frames = (PointFrame(xyz=xyz) for _ in range(3))
import_frames(frames, Path("still"), RecordingInfo("still", "still", 30))
recording = open_sequence(Path("still"))
seeds = [Seed(4, np.arange(100))]
run = METHODS["stay"]().track(
    recording.__getitem__, range(3), seeds, lambda frame: None, TrackOptions()
)
print(*METHODS)
print(*[f"{r.frame}:{np.array_equal(r.assignments[4], np.arange(100))}" for r in run])
"""


def test_the_documented_tracking_method_can_be_added(tmp_path: Path) -> None:
    example = documented("howto/tracker.md", "Add a method")
    groups = tomllib.loads(example["toml"])["project"]["entry-points"]
    about = tmp_path / "my_package-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Name: my_package")
    lines = [f"{n} = {t}" for n, t in groups["pointbrush.tracking"].items()]
    (about / "entry_points.txt").write_text("\n".join(["[pointbrush.tracking]", *lines]))
    (tmp_path / "my_package.py").write_text(example["python"])
    done = subprocess.run(
        [sys.executable, "-c", USE],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["auto icp color-icp stay", "0:True 1:True 2:True"]
