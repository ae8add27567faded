"""The documentation: what it says to type works.

A command or snippet that is not run has `<!-- not run: REASON -->` on the line before it, a page
none of which is run `<!-- page not run: REASON -->`.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from pointbrush.client import Client
from pointbrush.samples import generate
from pointbrush.sequences import RecordingInfo, import_frames
from pointbrush.settings import Settings
from pointbrush.workspace import Workspace
from tests import forked
from tests.depth_camera import grey_pictures
from tests.formats.test_bags import rosbag1
from tests.formats.test_joined_sensors import MOUNTS, rig, two_lidars
from tests.serving import TOKEN, serving, settings_in, surface
from tests.waiting import PATIENCE
from tests.work.test_box_import import sustechpoints

ROOT = Path(__file__).parent.parent
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "docs").rglob("*.md"))]
ADDRESS = "http://127.0.0.1:8080"
MOST_NOT_RUN = 23
FENCE = re.compile(
    r"(?:^<!-- not run: (?P<reason>.+?) -->\n)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.M | re.S
)
PAGE = re.compile(r"^<!-- page not run: (.+?) -->$", re.M)
COMMAND = re.compile(r"^ {4,}(?:\$ )?(pointbrush|python3?|pip|make|docker|dask|curl) \S.*", re.M)
PARSED: dict[str, Callable[[str], object]] = {
    "json": json.loads,
    "toml": tomllib.loads,
    "yaml": yaml.safe_load,
}
SHOWN = ("text", "http", "ts")
SERVERS = ("demo", "serve")
SHELL = frozenset("&|;<>*?$`")
"""Signs of a line that is for a shell."""
POINTS = 400
COLOUR_CAMERA = np.array([[30.0, 0, 32], [0, 30, 24], [0, 0, 1]])
"""K of a camera whose picture of 64 by 48 pixels shows the points."""
SAMPLE_FRAMES = 2


@dataclass(frozen=True)
class Snippet:
    """A fenced block of a page; ``reason`` why it is not run."""

    kind: str
    text: str
    reason: str | None


def snippets(page: Path) -> list[Snippet]:
    found = FENCE.finditer(page.read_text())
    return [Snippet(match["kind"], match["text"], match["reason"]) for match in found]


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


RUN = [
    page
    for page in PAGES[1:]  # the README has a test of its own
    if not PAGE.search(page.read_text())
    and any(each.kind in ("sh", "python") and each.reason is None for each in snippets(page))
]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_snippet_says_what_it_is(page: Path) -> None:
    for each in snippets(page):
        if each.kind in PARSED:
            PARSED[each.kind](each.text)
        elif each.reason is None and each.kind not in ("sh", "python", *SHOWN):
            pytest.fail(f"expected a snippet's language, got {each.kind!r}: {each.text[:80]}")
    rest = FENCE.sub("", page.read_text())
    if PAGE.search(rest):
        return
    assert not (found := COMMAND.search(rest)), f"{found[0]}: expected a command in a ```sh block"


def test_few_are_not_run_and_each_has_a_reason(capsys: pytest.CaptureFixture[str]) -> None:
    left = [
        f"{name_of(page)}: {each.text.splitlines()[0]}: {each.reason}"
        for page in PAGES
        for each in snippets(page)
        if each.reason
    ]
    for page in PAGES:
        left += [f"{name_of(page)}: {reason}" for reason in PAGE.findall(page.read_text())]
    with capsys.disabled():
        print(*(f"\nnot run: {line}" for line in left), end="")
    assert len(left) <= MOST_NOT_RUN


@dataclass(frozen=True)
class Place:
    """A folder with what the pages' commands name, and a workspace."""

    folder: Path
    settings: Settings

    def sh(self, text: str) -> None:
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if not words:
                continue
            if words[0] == "pointbrush" and words[1] in SERVERS:
                self._server([word for word in words[1:] if word != "&"])
                continue
            if words[0] == "pointbrush" and not SHELL.intersection(" ".join(words)):
                done = forked.run(*words[1:], environment=self._environment, cwd=self.folder)
                assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
                continue
            done = subprocess.run(
                ["bash", "-ec", line],
                cwd=self.folder,
                env=self._environment,
                capture_output=True,
                text=True,
                check=False,
                timeout=180,
            )
            assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"

    def _server(self, arguments: list[str]) -> None:
        """Start a server, and end it once it is ready."""
        few = ["--sample-frames", "1"] if arguments[0] == "demo" else []
        environment = self._environment | {"POINTBRUSH_WORKSPACE": str(self.folder / "other")}
        said, complaints = self.folder / "said", self.folder / "complaints"
        server = forked.ForkedCommand(
            [*arguments, *few], environment, said, complaints, self.folder
        )
        line = forked.first_line(server, said)
        server.send_signal(signal.SIGTERM)
        server.wait(PATIENCE)
        said.unlink()
        assert line.startswith("pointbrush ready at "), complaints.read_text()

    @property
    def _environment(self) -> dict[str, str]:
        return os.environ | {
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
            "POINTBRUSH_WORKSPACE": str(self.settings.workspace),
            "POINTBRUSH_PORT": "0",
        }


@pytest.fixture
def place(tmp_path: Path, request: pytest.FixtureRequest) -> Place:
    """A place with the recordings and files that a page takes as given."""
    text = request.param.read_text()
    settings = settings_in(tmp_path, import_roots=str(tmp_path))
    frames = 90 if "89" in text else 3
    given = [
        name
        for name in ("juggling", "room", "kitchen", "drive", "drive-fitted", "scene")
        if re.search(rf"\b{name}\b", text) and f"--name {name}" not in text
    ]
    if sample := request.param == README:
        given.remove("juggling")
    for name in given:
        import_frames(
            (surface(POINTS, i) for i in range(frames)),
            settings.workspace / "sequences" / name,
            RecordingInfo(name, name, 30.0),
            pictures=grey_pictures(frames, (64, 48), {"colour": COLOUR_CAMERA}),
        )
    workspace = Workspace(settings)
    for name in given:
        label = workspace.labels.create_label(name, "ada", name="car", category="car")
        values = np.zeros(POINTS, np.uint16)
        values[:100] = label.id
        workspace.annotations.put(name, 0, values, author="ada", layer="label")
    if sample:
        job = workspace.imports.begin_sample(frames=SAMPLE_FRAMES)
        assert workspace.runner.wait(job.id, PATIENCE).state == "done"
    workspace.close()
    write_files(tmp_path)
    return Place(tmp_path, settings)


def write_files(folder: Path) -> None:
    """Write small files of the kinds that the pages import."""
    rng = np.random.default_rng(0)
    for name in ("sequences/00/velodyne", "predictions", "samples/LIDAR_TOP", "lidarseg"):
        (folder / name).mkdir(parents=True)
    for name in ("recording", "scans", "kinect/depth", "kinect/color", "masks/depth"):
        (folder / name).mkdir(parents=True)
    labels = np.repeat([40, 10], POINTS // 2).astype("<u4")
    for i in range(3):
        points = rng.uniform(-1, 1, (POINTS, 5)).astype("<f4") * 10
        points[:, :4].tofile(folder / f"sequences/00/velodyne/{i:06}.bin")
        points.tofile(
            folder / f"samples/LIDAR_TOP/LIDAR_TOP__{1532402927647951 + i * 50000}.pcd.bin"
        )
        labels.tofile(folder / f"predictions/{i:06}.label")
        labels.astype(np.uint8).tofile(folder / f"lidarseg/{i:06}_lidarseg.bin")
        np.save(folder / f"recording/{i}.npy", points[:, :3])
        if i > 1:
            continue
        depth = rng.integers(900, 1100, (424, 512)).astype(np.uint16)
        Image.fromarray(depth).save(folder / f"kinect/depth/{i}.png")
        Image.fromarray(np.where(depth > 1000, 10, 0).astype(np.uint8)).save(
            folder / f"masks/depth/{i}.png"
        )
        color = rng.integers(0, 255, (424, 512, 3)).astype(np.uint8)
        Image.fromarray(color).save(folder / f"kinect/color/{i}.png")
    labels.tofile(folder / "000000.label")
    (folder / "classes.txt").write_text("10 car\n40 road\n")
    (folder / "annotations").mkdir()
    sustechpoints(folder / "annotations")
    rig(folder / "rig")
    (folder / "rig" / "extrinsics.json").write_text(
        json.dumps({name: {"T_frame_sensor": T.tolist()} for name, T in MOUNTS.items()})
    )
    two_lidars(folder).rename(folder / "lidars.bag")
    (folder / "drive.bag").write_bytes(rosbag1())
    odometry = "".join(f"{100 + k} {k} 0 0 0 0 0 1\n" for k in range(5))
    (folder / "odometry.txt").write_text(odometry)
    report = ROOT / "tests" / "golden" / "headset-vive.json"
    shutil.copy(report, folder / "headset-report-2026-11-27.json")


@pytest.mark.parametrize(
    ("page", "place"), [(page, page) for page in RUN], indirect=["place"], ids=map(name_of, RUN)
)
def test_what_a_page_says_to_type_works(
    page: Path, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    type_in(page, place, monkeypatch)


@pytest.mark.parametrize("place", [README], indirect=True, ids=["README.md"])
def test_the_readme_labels_the_red_pin(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    names = type_in(README, place, monkeypatch)
    made = generate("juggling", seed=0, frames=SAMPLE_FRAMES)
    with zipfile.ZipFile(place.folder / "juggling.zip") as exported:
        for i, truth in enumerate(made.truth):
            labelled = np.load(exported.open(f"label/{i:06}.npy")) == names["pin"].id
            assert (labelled & (truth == 1)).sum() > 0.7 * (labelled | (truth == 1)).sum()


def type_in(page: Path, place: Place, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Run a page's snippets, those of the client against a server; returns the names they make."""
    monkeypatch.chdir(place.folder)
    run = [each for each in snippets(page) if each.reason is None]
    names: dict[str, Any] = {"token": TOKEN}
    if not any(each.kind == "python" and "client" in each.text.lower() for each in run):
        run_all(run, place, names, ADDRESS)
        return names
    with serving(place.settings) as served, Client(served.url, TOKEN) as client:
        names["client"] = client
        run_all(run, place, names, served.url)
    return names


def run_all(run: list[Snippet], place: Place, names: dict[str, Any], url: str) -> None:
    for each in run:
        if each.kind == "sh":
            place.sh(each.text)
        elif each.kind == "python":
            exec(compile(each.text.replace(ADDRESS, url), "snippet", "exec"), names)
