"""The client's own package: small, and beside `pointbrush` in any order."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.release.test_wheel import ROOT, build, install
from tests.serving import TOKEN, add_sequence, serving, settings_in

USE = """
import sys
from pointbrush.client import Client

with Client(sys.argv[1], sys.argv[2]) as client:
    wall = client["wall"]
    label = wall.create_label("wall")
    centre = wall.frames[0].points()["xyz"][0].tolist()
    edit = wall.frames[0].stroke(label=label.id, radius=0.2, samples=[centre])
    assert edit.changed > 0
    assert (wall.frames[0].annotation() == label.id).sum() == edit.changed
assert not {"numba", "scipy", "dask", "pyarrow", "fastapi"} & set(sys.modules)
"""
DOCUMENTED = re.compile(r"^pip install .*$", re.M)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(ROOT / "server" / "client_package", "wheel", tmp_path_factory.mktemp("dist"))


@pytest.mark.timeout(900)
def test_the_documented_ways_to_install_it_work(client: Path, tmp_path: Path) -> None:
    page = (ROOT / "docs" / "scripting.md").read_text(encoding="utf-8")
    checkout, wheel, index = DOCUMENTED.findall(page)
    programs = install(client, tmp_path / "fresh")
    (tmp_path / "server").symlink_to(ROOT / "server")
    (tmp_path / "dist").symlink_to(client.parent)
    environment = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    # Nothing is published yet: a folder of wheels stands for the index.
    local = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(client.parent)}
    for command, more in ((checkout, {}), (wheel, local), (index, local)):
        pip = f"pip uninstall --yes pointbrush-client && {command}"
        script = f"{pip} && python -c 'import pointbrush.client'"
        subprocess.run(
            ["bash", "-ec", script], env=environment | more, cwd=tmp_path, check=True, timeout=300
        )


@pytest.mark.timeout(900)
def test_the_client_alone_works_and_goes_beside_pointbrush(client: Path, tmp_path: Path) -> None:
    whole = build(ROOT, "wheel", tmp_path / "whole")
    programs = install(client, tmp_path / "fresh")

    def pip(*arguments: object) -> None:
        command = [programs / "python", "-m", "pip", "--quiet", *arguments]
        subprocess.run(list(map(str, command)), check=True, timeout=120)

    settings = settings_in(tmp_path)
    add_sequence(settings, "wall", frames=1)
    with serving(settings) as served:

        def use() -> None:
            command = [programs / "python", "-B", "-c", USE, served.url, TOKEN]
            subprocess.run(command, check=True, cwd=tmp_path, timeout=120)

        use()
        for first, second in ((client, whole), (whole, client)):
            for gone in ("pointbrush", "pointbrush-client"):
                pip("uninstall", "--yes", "pointbrush", "pointbrush-client")
                pip("install", "--no-deps", first)
                pip("install", "--no-deps", second)
                use()
                pip("uninstall", "--yes", gone)
                use()
