"""The packages that pointbrush needs: bounds on both ends, and the pinned versions within them."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent


def required(project: str) -> dict[str, Requirement]:
    """All packages that a project file names, by name; its own extras name it too."""
    found = tomllib.loads((ROOT / project / "pyproject.toml").read_text())["project"]
    extras = found.get("optional-dependencies", {}).values()
    each = map(Requirement, [*found["dependencies"], *(text for extra in extras for text in extra)])
    return {canonicalize_name(one.name): one for one in each if one.name != found["name"]}


@pytest.mark.parametrize("project", [".", "server/client_package"])
def test_each_dependency_has_both_bounds_with_its_pinned_version_between(project: str) -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    told = [line for line in lines if line and line[0] not in "#-"]
    pins = {canonicalize_name(one.name): one.specifier for one in map(Requirement, told)}
    for name, each in required(project).items():
        assert {bound.operator for bound in each.specifier} == {">=", "<"}, name
        for pin in pins.get(name, ()):
            assert pin.version in each.specifier, name


def test_the_client_alone_takes_what_the_whole_takes() -> None:
    whole = required(".")
    for name, each in required("server/client_package").items():
        assert each.specifier == whole[name].specifier, name
