"""The documented examples work as documented."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
from serving import TOKEN, serving, settings_in

ROOT = Path(__file__).parent.parent


def test_the_rest_example_runs_against_a_real_server(tmp_path: Path) -> None:
    recording = tmp_path / "drift"
    recording.mkdir()
    rng = np.random.default_rng(0)
    cube = rng.uniform(-0.1, 0.1, (4000, 3))
    for i in range(3):
        np.save(recording / f"{i}.npy", (cube + [0.01 * i, 0, 2]).astype(np.float32))
    settings = settings_in(tmp_path, import_roots=str(tmp_path))
    script = ROOT / "docs" / "examples" / "label_over_rest.py"
    with serving(settings) as served:
        done = subprocess.run(
            [sys.executable, script, served.url, TOKEN, recording],
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
    assert done.returncode == 0, done.stderr
    assert "painted" in done.stdout
    assert "frame 2: tracked" in done.stdout
    assert "export:" in done.stdout


def documented(page: str, heading: str) -> dict[str, str]:
    """Language → the code of that language under a heading of a page of ``docs/``."""
    text = (ROOT / "docs" / page).read_text()
    section = text.split(f"## {heading}\n")[1].split("\n## ")[0]
    return dict(re.findall(r"```(\w+)\n(.*?)```", section, re.DOTALL))


USE = """
import numpy as np
from pointbrush.frame import PointFrame
from pointbrush.sequences import import_frames, open_sequence
from pointbrush.tracking import METHODS, Seed, TrackOptions
from pathlib import Path

xyz = np.random.default_rng(0).uniform(1, 2, (500, 3)).astype(np.float32)
frames = (PointFrame(xyz=xyz) for _ in range(3))
import_frames(frames, Path("still"), sequence_id="still", name="still", fps=30)
recording = open_sequence(Path("still"))
seeds = [Seed(4, np.arange(100))]
run = METHODS["stay"]().track(
    recording.__getitem__, range(3), seeds, lambda frame: None, TrackOptions()
)
print(*METHODS)
print(*[f"{r.frame}:{np.array_equal(r.assignments[4], np.arange(100))}" for r in run])
"""


def test_the_documented_tracking_method_can_be_added(tmp_path: Path) -> None:
    example = documented("tracking.md", "Adding a method")
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
