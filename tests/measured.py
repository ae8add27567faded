"""Order of the files of tests by their seconds, and the files that `make quick` runs.

python -m tests.measured    # prints the files of `make quick`
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
FILE = TESTS / "seconds.json"
"""Seconds of each file of tests on one core, from `make measure`."""
QUICK = {
    "paint points": (
        "selection/test_select.py",
        "selection/test_objects.py",
        "labels/test_model.py",
    ),
    "undo": ("labels/test_undo.py", "database/test_round_trips.py"),
    "track labels": ("tracking/test_methods.py", "tracking/test_held.py", "tracking/test_lidar.py"),
    "fit boxes": ("fitting/test_fitting.py", "labels/test_boxes.py"),
    "label by example": (
        "classify/test_classifier.py",
        "classify/test_features.py",
        "web/test_classifier_calls.py",
    ),
    "keep every edit": ("database/test_durability.py", "labels/test_whole_edits.py"),
    "open older workspaces": ("database/test_migrate.py", "database/test_old_workspace.py"),
    "play frames": (
        "streaming/test_socket_points.py",
        "streaming/test_plan.py",
        "sequences/test_codec.py",
    ),
    "work together": (
        "streaming/test_socket_edits.py",
        "labels/test_together.py",
        "web/test_projects.py",
    ),
    "review": ("web/test_review_calls.py", "work/reviewing/test_agreement.py"),
    "refuse strangers": ("web/test_auth.py", "streaming/test_socket_refusals.py"),
    "import and export": (
        "sequences/test_importer.py",
        "work/test_round_trip.py",
        "formats/test_exports.py",
        "formats/test_kitti.py",
        "formats/test_las.py",
        "formats/test_pcd.py",
        "formats/test_ply.py",
        "formats/test_bags.py",
        "formats/test_rgbd.py",
        "formats/test_box_round_trips.py",
    ),
    "write scripts": ("web/test_rest.py", "web/test_selection.py"),
    "keep the structure": ("test_import_circles.py", "test_words.py", "test_published_schemas.py"),
}
"""Files of tests that `make quick` runs, by the behaviour that they represent."""
UNMEASURED = ("e2e", "release")


def read() -> dict[str, float]:
    found: dict[str, float] = json.loads(FILE.read_text())
    return found


def arrange(items: list[pytest.Item]) -> None:
    """Start the longest files first.

    A long file that starts last would keep one worker busy while the other is idle.
    """
    seconds = read()
    items.sort(key=lambda item: -seconds.get(item.path.relative_to(TESTS).as_posix(), 0.0))


class Measuring:
    """A plugin that writes the seconds of each file to FILE."""

    def __init__(self) -> None:
        self._taken: Counter[str] = Counter()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._taken[report.nodeid.split("::")[0].removeprefix("tests/")] += report.duration

    def pytest_sessionfinish(self) -> None:
        write({**read(), **self._taken})


def write(seconds: Mapping[str, float]) -> None:
    """Write FILE, without files that are gone and browser tests."""
    kept = {
        name: round(taken, 1)
        for name, taken in sorted(seconds.items())
        if (TESTS / name).is_file() and name.split("/")[0] not in UNMEASURED
    }
    FILE.write_text(json.dumps(kept, indent=0) + "\n")


if __name__ == "__main__":
    print(*(f"tests/{name}" for names in QUICK.values() for name in names))
