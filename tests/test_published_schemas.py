"""Files that other programs read follow the schemas which these programs publish."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parent.parent
WORKFLOWS = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob(".github/workflows/*.yml"))


@pytest.mark.parametrize(
    ("schema", "name"),
    [
        ("compose-spec", "docker-compose.yml"),
        *(("github-workflows", name) for name in WORKFLOWS),
        ("dependabot", ".github/dependabot.yml"),
        ("citation-file-format", "CITATION.cff"),
    ],
)
def test_a_file_follows_its_schema(schema: str, name: str) -> None:
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
    checked = subprocess.run([*command, str(ROOT / name)], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_a_release_begins_at_a_tag_and_each_job_has_the_least_rights() -> None:
    release = yaml.load((ROOT / ".github/workflows/release.yml").read_text(), yaml.BaseLoader)
    assert list(release["on"]) == ["push"]
    assert list(release["on"]["push"]) == ["tags"]
    assert release["permissions"] == {"contents": "read"}
    assert {
        name: job["permissions"] for name, job in release["jobs"].items() if "permissions" in job
    } == {
        "publish": {"id-token": "write"},
        "image": {"contents": "read", "packages": "write"},
        "site": {"contents": "read", "id-token": "write", "pages": "write"},
    }
