"""Selecting objects as people do: files imported by the command line, clicks asked over REST.

python benchmarks/bench_clicks.py [--kinds KIND ...] [--seeds N] [--from SEED] [--every K]

``shown`` is the level shown first, which a person takes and goes on from, as the page does;
``wheel`` the best of the levels offered; ``stroke`` some points along the object at once.
``harmful``: further clicks after which the level shown is worse by more than 0.02.  Generated
scenes have seeds that no training sees.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import plyfile
from bench_effort import serving
from numpy.typing import NDArray
from object_clicks import LEAST_POINTS, Mask, iou, next_click, objects, stroke
from object_scenes import GENERATED, HELD_OUT, Scene

CLICKS = (1, 2, 3, 6)
STROKES = (5, 12)
"""Points of a stroke."""
UP = {"lidar": "y", "camera": "-y", "room": "y"}
"""Axes of the frames."""
HARM = 0.02
EYE, TUBE = 0.35, 0.03
"""Metres: how far from the surface a ray begins, and how clear its way is."""
WAYS = np.array([[x, y, z] for x in (-1, 0, 1) for y in (0, 1) for z in (-1, 0, 1) if x or y or z])
"""Directions that a click may come from."""
Answer = tuple[list[Mask], list[str], int]


def write_ply(path: Path, scene: Scene) -> None:
    """Write a scene's points and colours."""
    columns: list[NDArray[Any]] = [*np.asarray(scene.frame.xyz, np.float32).T]
    names = ["x", "y", "z"]
    if scene.frame.rgb is not None:
        columns += [*scene.frame.rgb.T]
        names += ["red", "green", "blue"]
    elif scene.frame.intensity is not None:
        columns.append(np.asarray(scene.frame.intensity, np.float32))
        names.append("intensity")
    rows = np.rec.fromarrays(columns, names=",".join(names))
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")]).write(path)


def import_scene(scene: Scene, name: str, folder: Path) -> None:
    """Import a scene from a file by the command line."""
    write_ply(folder / f"{name}.ply", scene)
    command = [sys.executable, "-m", "pointbrush.cli", "import", str(folder / f"{name}.ply")]
    command += ["--name", name, "--workspace", str(folder / "workspace")]
    command.append(f"--up={UP[scene.frame.sensor]}")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def ray(scene: Scene, at: NDArray[np.float64]) -> dict[str, list[float]]:
    """Ray that meets the surface at a point: from the sensor, else from where the way is clear."""
    if scene.frame.viewpoint is not None:
        origin = np.asarray(scene.frame.viewpoint, float)
    else:
        xyz = scene.frame.xyz
        near = xyz[(np.abs(xyz - at) < EYE + TUBE).all(axis=1)] - at
        ways = WAYS / np.linalg.norm(WAYS, axis=1, keepdims=True)
        along = near @ ways.T
        aside = np.sqrt(np.maximum((near**2).sum(axis=1)[:, None] - along**2, 0))
        within = (along > 2 * TUBE) & (along < EYE) & (aside < TUBE)
        origin = at + EYE * ways[int(within.sum(axis=0).argmin())]
    way = at - origin
    way = way / np.linalg.norm(way)
    return {"origin": origin.tolist(), "direction": way.tolist()}


class Session:
    """One object of one imported scene."""

    def __init__(self, api: httpx.Client, name: str, scene: Scene, number: int) -> None:
        self._api, self._scene = api, scene
        self._path = f"/sequences/{name}/frames/0/object"
        self.truth = scene.instance == number
        self.seconds: list[float] = []

    def ask(self, wanted: list[Any], unwanted: list[Any], previous: str = "") -> Answer:
        """Masks of the levels offered, their ids, and which one is shown first."""
        body = {"positives": wanted, "negatives": unwanted, "previous": previous, "radius": 0.02}
        begun = time.perf_counter()
        answer = self._api.post(self._path, json=body).raise_for_status().json()
        self.seconds.append(time.perf_counter() - begun)
        masks = []
        for each in answer["candidates"]:
            mask = np.zeros(len(self.truth), np.bool_)
            for first, length in each["runs"]:
                mask[first : first + length] = True
            masks.append(mask)
        return masks, [each["id"] for each in answer["candidates"]], answer["first"]

    def clicks(self, *, best: bool) -> list[float]:
        """IoU after each click; the best level is taken each time, or the one that is shown."""
        wanted: list[Any] = []
        unwanted: list[Any] = []
        previous, taken = "", None
        reached: list[float] = []
        for _ in range(max(CLICKS)):
            click = next_click(self._scene.frame.xyz, self.truth, taken)
            if click is None:
                break
            (wanted if click[1] else unwanted).append(ray(self._scene, click[0]))
            masks, ids, first = self.ask(wanted, unwanted, previous)
            if masks:
                overlaps = [iou(mask, self.truth) for mask in masks]
                chosen = int(np.argmax(overlaps)) if best else first
                previous, taken = ids[chosen], masks[chosen]
            reached.append(0.0 if taken is None else iou(taken, self.truth))
        return reached + reached[-1:] * (max(CLICKS) - len(reached))

    def stroke(self, points: int, number: int) -> tuple[float, float]:
        """IoU of the level shown for a stroke, and of the best one."""
        marks = stroke(self._scene.frame.xyz, self.truth, points, np.random.default_rng(number))
        masks, _, first = self.ask([ray(self._scene, mark) for mark in marks], [])
        overlaps = [iou(mask, self.truth) for mask in masks] or [0.0]
        return overlaps[first], max(overlaps)


def ready(api: httpx.Client, name: str, scene: Scene) -> None:
    """Wait until the frame is prepared."""
    body = {"positives": [ray(scene, np.asarray(scene.frame.xyz[0], float))], "negatives": []}
    path = f"/sequences/{name}/frames/0/object"
    while not api.post(path, json=body).raise_for_status().json()["ready"]:
        time.sleep(0.2)


def score(api: httpx.Client, name: str, scene: Scene, every: int) -> dict[str, list[float]]:
    """Figures of a scene's objects by name."""
    scores: dict[str, list[float]] = defaultdict(list)
    for number in objects(scene.instance, LEAST_POINTS[scene.frame.sensor])[::every]:
        session = Session(api, name, scene, number)
        for way in ("shown", "wheel"):
            reached = session.clicks(best=way == "wheel")
            for k in CLICKS:
                scores[f"{way} {k}"].append(reached[k - 1])
            if way == "shown":
                scores["harmful"] += [float(b < a - HARM) for a, b in pairwise(reached)]
        for points in STROKES:
            shown, best = session.stroke(points, number)
            scores[f"stroke of {points}"].append(shown)
            scores[f"stroke of {points}, wheel"].append(best)
        scores["ms"] += [1e3 * s for s in session.seconds]
    return scores


def main() -> None:
    """Print a line for each kind of scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kinds", nargs="*", default=["home", "scan"], choices=GENERATED)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--from", dest="first", type=int, default=HELD_OUT)
    parser.add_argument("--every", type=int, default=1, help="every so many of the objects")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as root:
        folder = Path(root)
        scenes: dict[str, list[tuple[str, Scene]]] = defaultdict(list)
        for kind in given.kinds:
            for seed in range(given.first, given.first + given.seeds):
                name, scene = f"{kind}-{seed}", GENERATED[kind](seed)
                import_scene(scene, name, folder)
                scenes[kind].append((name, scene))
        with serving(folder / "workspace") as api:
            for kind, made in scenes.items():
                every: dict[str, list[float]] = defaultdict(list)
                for name, scene in made:
                    ready(api, name, scene)
                    for key, values in score(api, name, scene, given.every).items():
                        every[key] += values
                figures = "  ".join(
                    f"{key} {np.mean(values):.2f}" for key, values in every.items() if key != "ms"
                )
                slow = np.quantile(every["ms"], 0.95)
                print(
                    f"{kind:9} {len(every['shown 1']):3} objects  {figures}  p95 {slow:.0f} ms",
                    flush=True,
                )


if __name__ == "__main__":
    main()
