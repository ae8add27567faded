"""Samples are the same on every processor: each kind's hash, whatever code paths libraries take."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pointbrush_samples
from pointbrush import samples
from pointbrush.samples.aerial import AerialOptions, aerial_tile
from pointbrush.samples.generating import generate, small_camera
from pointbrush.samples.reproducible import asin, atan2, cos, cosines, sin, sines
from pointbrush.samples.sensor import KINECT
from pointbrush.samples.stage import Stage, StageOptions
from pointbrush_samples.contacts import contact_view
from pointbrush_samples.driving import drive
from pointbrush_samples.scanning import FUSED, WIDE, Labelled, home_scan, room_scan, room_view
from pointbrush_samples.street import street
from pointbrush_samples.traffic import traffic

SOURCES = [
    path
    for package in (samples, pointbrush_samples)
    for path in Path(package.__file__).parent.glob("*.py")
]
HASHES: Mapping[str, str] = {
    "crowd": "a9e2ece799098ae5",
    "juggling": "2078760412fc6092",
    "3-pins": "ac8cfeaa090b247d",
    "tabletop": "ac67ab52fce618fb",
    "walking": "4d8f580bfd00c0eb",
    "stage": "63de89a2ecaa8f15",
    "aerial": "dd276f2fee4a2bba",
    "room": "9b9c750107d8b422",
    "home": "491f3fdfb4f0458b",
    "view": "916113e71b490eee",
    "street": "15735c03332444d7",
    "drive": "d4d3ec345e30e005",
    "traffic": "da71520bec7e11d3",
}
"""Of each kind, on any x86-64 processor; a change of the samples changes them."""

FOUND = np.show_config("dicts")["SIMD Extensions"].get("found", [])  # type: ignore[call-overload]
ENVIRONMENTS = {
    "this": {},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "oldest": {
        "OPENBLAS_CORETYPE": "Nehalem",
        "NPY_DISABLE_CPU_FEATURES": " ".join(FOUND),
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-AVX,-FMA,-FMA4",
    },
}
"""Variables by the processor whose code paths OpenBLAS, NumPy and the C library take then."""
PROCESSOR_DEPENDENT = re.compile(
    r"\bnp\.(linalg|einsum|dot|matmul|sin|cos|tan|arc|exp|log|pow|hypot)"
    r"|\bmath\.(sin|cos|tan|asin|acos|atan|exp|log|pow)\w*\("
    r"|rng\.(normal|standard_normal|standard_exponential|exponential|beta|gamma)\("
    r"|\w @ \w|gaussian_filter"
)


def recorded(kind: str, **options: object) -> Iterator[np.ndarray]:
    made = generate(kind, seed=2, frames=2, **options)  # type: ignore[arg-type]
    made.camera = small_camera(made.camera, 3)
    for i in range(2):
        yield from (made.frame(i).xyz, made.frame(i).rgb, made.truth[i])
    for poses in made.poses.values():
        yield from poses


def staged() -> Iterator[np.ndarray]:
    options = StageOptions(error_metres=0.02, error_degrees=2.0)
    made = Stage(2, 2, options, camera=small_camera(KINECT, 3))
    for i in range(2):
        yield from (made.frame(i).xyz, made.frame(i).rgb, made.truth[i])
    yield from (*made.true_mounts, *made.mounts)


def labelled(*made: Labelled) -> Iterator[np.ndarray]:
    for each in made:
        colours = each.frame.intensity if each.frame.rgb is None else each.frame.rgb
        yield from (each.frame.xyz, colours, each.instance, each.T_room_frame)


def tile() -> Iterator[np.ndarray]:
    made = aerial_tile(2, AerialOptions(edge=60, houses=20, trees=40, cars=9))
    yield from (made.xyz, made.intensity, made.label, *made.other.values())


def boxed() -> Iterator[np.ndarray]:
    made = traffic(2, 2)
    yield from labelled(*made.frames)
    for box in made.boxes.values():
        yield box.size
        yield from (each for p in box.poses.values() for each in (p.centre, p.quaternion))


KINDS = {
    "crowd": lambda: recorded("crowd"),
    "juggling": lambda: recorded("juggling", like_clothes=True),
    "3-pins": lambda: recorded("juggling", pins=3, passing=False, held=2),
    "tabletop": lambda: recorded("tabletop", label_people=True),
    "walking": lambda: recorded("walking", boxes=2),
    "stage": staged,
    "aerial": tile,
    "room": lambda: labelled(room_scan(2, 20_000, views=2)),
    "home": lambda: labelled(home_scan(2, replace(FUSED, points=20_000, views=3))),
    "view": lambda: labelled(room_view(2, WIDE), contact_view(2, WIDE)),
    "street": lambda: labelled(street(2)),
    "drive": lambda: labelled(*drive(2, 2)),
    "traffic": boxed,
}


def hash_of(arrays: Iterator[np.ndarray]) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="hashes are of x86-64")
@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_every_kind_is_the_same_whatever_the_processor_can(name: str) -> None:
    if name == "Haswell" and not FOUND:
        pytest.skip(f"this processor cannot run the kernels of {name}")
    child = subprocess.run(
        [sys.executable, __file__],
        env=os.environ | ENVIRONMENTS[name],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert json.loads(child.stdout) == HASHES


@pytest.mark.parametrize(
    "path", sorted(SOURCES), ids=lambda path: f"{path.parent.name}.{path.stem}"
)
def test_samples_use_no_arithmetic_that_depends_on_the_processor(path: Path) -> None:
    found = [line for line in path.read_text().splitlines() if PROCESSOR_DEPENDENT.search(line)]
    assert found == [] or path.stem == "reproducible"


def test_own_functions_are_as_exact_as_the_library() -> None:
    angles = np.random.default_rng(1).uniform(-50, 50, 2000)
    np.testing.assert_allclose(sines(angles), np.sin(angles), atol=4e-15)
    np.testing.assert_allclose(cosines(angles), np.cos(angles), atol=4e-15)
    for y, x in [*angles.reshape(-1, 2).tolist(), (0.0, 0.0), (0.0, -1.0), (-1.0, 0.0)]:
        assert math.isclose(atan2(y, x), math.atan2(y, x), abs_tol=4e-15)
        assert math.isclose(sin(x), math.sin(x), abs_tol=4e-15)
        assert math.isclose(cos(x), math.cos(x), abs_tol=4e-15)
        assert math.isclose(asin(x / 50), math.asin(x / 50), abs_tol=4e-15)


if __name__ == "__main__":
    print(json.dumps({kind: hash_of(make()) for kind, make in KINDS.items()}))
