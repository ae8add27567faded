"""The metadata of both packages: licence, classifiers, and addresses that a release sets."""

from __future__ import annotations

import tarfile
from email.message import Message
from pathlib import Path
from typing import Any

import pytest
from build.util import project_wheel_metadata

from tests.release.test_wheel import ROOT, build

REPOSITORY = "https://code.example.org/lab/pointbrush"
CLIENT = ROOT / "server" / "client_package"


def metadata(source: Path) -> Any:
    found: Message = project_wheel_metadata(source)  # type: ignore[assignment]
    return found


@pytest.mark.timeout(600)
@pytest.mark.parametrize("source", [ROOT, CLIENT], ids=["whole", "client"])
def test_a_package_names_its_licence_and_no_address_until_one_is_set(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("POINTBRUSH_REPOSITORY", raising=False)
    found = metadata(source)
    assert found["License-Expression"] == "Apache-2.0"
    assert found.get_all("License-File") == ["LICENSE"]
    assert "Programming Language :: Python :: 3.11" in found.get_all("Classifier")
    assert found.get_all("Project-URL") is None
    monkeypatch.setenv("POINTBRUSH_REPOSITORY", f"{REPOSITORY}/")
    addresses = dict(each.split(", ") for each in metadata(source).get_all("Project-URL"))
    assert addresses["Source"] == REPOSITORY
    assert addresses["Changelog"].startswith(f"{REPOSITORY}/blob/v{found['Version']}/")


@pytest.mark.timeout(600)
def test_links_of_the_readme_lead_to_the_repository_from_an_index(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("POINTBRUSH_REPOSITORY", REPOSITORY)
    with tarfile.open(build(ROOT, "sdist", tmp_path)) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    monkeypatch.delenv(
        "POINTBRUSH_REPOSITORY"
    )  # a source archive keeps the addresses of its release
    (source,) = (tmp_path / "source").iterdir()
    found = metadata(source)
    text, tag = found.get_payload(), f"v{found['Version']}"
    assert f"]({REPOSITORY}/blob/{tag}/docs/tutorial.md)" in text
    assert f"]({REPOSITORY}/raw/{tag}/docs/images/desk.jpg)" in text
    assert "](docs/" not in text
    assert found.get_all("Project-URL")
