"""The documented example works as documented."""

from __future__ import annotations

import subprocess
import sys
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
