"""Options of the tracker: values are checked, and no tunable number stands outside of them."""

from __future__ import annotations

import ast
from dataclasses import fields, replace
from pathlib import Path

import pytest

import pointbrush.tracking
from pointbrush.errors import BadInputError
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.options.base import Options
from pointbrush.tracking.options.sensors import ScanOdometryOptions, VisualOdometryOptions
from pointbrush.tracking.options.steps import ContextOptions, RegistrationOptions
from pointbrush.tracking.options.tracks import CompanionOptions, JumpOptions

ROOT = Path(pointbrush.tracking.__file__).parent
DEFINITIONS = {
    "scene/images.py": {"DEVIATION"},  # 1.4826 / sqrt(2)
    "duplicates.py": {"REMEMBERED"},  # size of a cache, in frames
    "steps/propose.py": {"OPPOSITE", "ALONG"},  # rounding of directions
    "compute/columns.py": {"PER_COLUMN"},  # layout of a search grid
    "compute/grid.py": {"MOST_ACROSS", "SPARE", "MOST_NEAR", "RUN"},  # likewise
    "interface.py": {"PAINTED", "USUAL_FPS"},  # code of a provenance
    "model/appearance.py": {"BIN", "LIKE", "LOW", "SHAPE"},  # layout of a histogram
    "model/confidence.py": {
        "RATIO_LEAST",
        "MOST_LOG_ODDS",
    },  # keep logarithms and exponentials finite
    "model/track.py": {"SIDES"},  # unit vectors
    "icp.py": {"LONE", "FINEST", "SAMPLE"},  # of the paper's method, not of `auto`
    "people/strides.py": {"GRID"},  # nodes of a search grid
    "people/foreground.py": {"OTHER"},  # code of a label
    "scene/depth.py": {"NEVER"},  # more than any number of frames
    "registry.py": {"COLOUR_NEIGHBOURS"},  # of the paper's method
    "permissions.py": {"FEWEST"},  # part of the label store's contract
    "sensors/sights.py": {"GAP"},  # layout of a depth image
    "sensors/visual_odometry.py": {"SPREAD"},  # 1.4826
    "sensors/view.py": {"WHITE"},  # 3 * 255
}
"""Numbers that belong to a definition, by module."""


def _number(node: ast.expr) -> bool:
    return (
        ast.unparse(node)[:8] != "np.empty"
        and any(
            isinstance(part, ast.Constant) and type(part.value) in (int, float)
            for part in ast.walk(node)
        )
        and not any(isinstance(part, ast.Lambda | ast.Subscript) for part in ast.walk(node))
    )


def _bound_numbers(path: Path) -> set[str]:
    found = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Assign) and _number(node.value):
            for target in node.targets:
                found |= {part.id for part in ast.walk(target) if isinstance(part, ast.Name)}
        elif isinstance(node, ast.AnnAssign) and node.value is not None and _number(node.value):
            found.add(ast.unparse(node.target))
    return found


def test_numbers_stand_in_the_options_alone() -> None:
    found = {}
    for path in ROOT.rglob("*.py"):
        where = path.relative_to(ROOT).as_posix()
        if not where.startswith("options/") and (names := _bound_numbers(path)):
            found[where] = names
    assert found == DEFINITIONS
    assert sum(map(len, found.values())) <= 40


def test_the_tree_is_made_of_its_defaults() -> None:
    assert TrackerOptions() == TrackerOptions(CompanionOptions(), JumpOptions())
    assert all(
        isinstance(getattr(TrackerOptions(), f.name), Options) for f in fields(TrackerOptions)
    )


def test_an_experiment_is_another_value() -> None:
    options = TrackerOptions()
    tried = replace(options, register=replace(options.register, doubt=0.5))
    assert (tried.register.doubt, options.register.doubt) == (0.5, 0.27)


def test_a_value_out_of_its_bounds_is_named() -> None:
    with pytest.raises(BadInputError, match=r"JumpOptions\.stays_share: expected .* 0 to 1, got 1"):
        JumpOptions(stays_share=1.5)
    with pytest.raises(BadInputError, match=r"CompanionOptions\.most: expected a whole number"):
        CompanionOptions(most=-1)
    with pytest.raises(BadInputError, match=r"doubt: expected a number from 0 to inf, got nan"):
        RegistrationOptions(doubt=float("nan"))
    with pytest.raises(BadInputError, match=r"max_points: expected a whole number above 0"):
        ContextOptions(max_points=0)  # something is divided by it
    with pytest.raises(BadInputError, match=r"side_pixels: expected a whole .* got '64'"):
        JumpOptions(side_pixels="64")  # type: ignore[arg-type]
    with pytest.raises(BadInputError, match=r"tested_frames: expected a whole number"):
        ScanOdometryOptions(tested_frames=(1, 2.5, 3))  # type: ignore[arg-type]
    assert VisualOdometryOptions(start_aside_px=(-1.0, 1.0)).start_aside_px[0] < 0
