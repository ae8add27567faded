"""A simulated person who labels a recording over REST with brushes, and counts the work.

The annotator knows the truth and looks at one frame at a time.  A stroke is what a hand does
between pressing and releasing the trigger: a ball of one size, moved along a path, with 3 mm of
tremor.  Each stroke goes where it mends most: the worst object first, there the largest patch that
is wrong, painted or erased with the ball and path that put most points right; with the object
tool, also by a click in the middle of that patch and the level that puts most points right.
"""

from __future__ import annotations

import io
import itertools
import time
import uuid
from dataclasses import dataclass, field

import httpx
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label as connected
from scipy.spatial import cKDTree

GOAL = 0.9
"""IoU at which a frame (mean over its objects) needs no more work."""
VISIBLE = 40
"""Points from which an object counts."""
RADII = (0.012, 0.02, 0.03, 0.045, 0.07, 0.10, 0.15, 0.22)
TREMOR = 0.003
CELL = 0.04
MOST_STROKES = 60
"""Strokes in a frame after which the annotator leaves it as it is."""

Labels = NDArray[np.uint16]


@dataclass
class View:
    """A frame as the annotator sees it, source order."""

    xyz: NDArray[np.float32]
    truth: Labels
    tree: cKDTree = field(init=False)

    def __post_init__(self) -> None:
        self.tree = cKDTree(self.xyz)

    def swept(self, path: NDArray[np.float64], radius: float) -> NDArray[np.intp]:
        """Points within ``radius`` of the path's segments."""
        dense = densified(path, radius)
        found = self.tree.query_ball_point(dense, radius * 1.2, return_sorted=False)
        near = np.unique(np.concatenate([np.asarray(f, np.intp) for f in found]))
        return near[distance_to_path(self.xyz[near], path) <= radius]


@dataclass
class Stroke:
    """One planned stroke and how many more points it puts right than wrong."""

    label: int
    tool: str
    path: NDArray[np.float64]
    radius: float
    gain: int
    only_unlabeled: bool = False


@dataclass
class Click:
    """One click of the object tool, the level that was chosen, and its gain as of a stroke."""

    label: int
    ray: dict[str, list[float]]
    candidate: str
    gain: int


def densified(path: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """The path with points no farther apart than half a radius."""
    pieces = [path[:1]]
    for a, b in itertools.pairwise(path):
        steps = max(1, int(np.ceil(np.linalg.norm(b - a) / (0.5 * radius))))
        pieces.append(a + (b - a) * (np.arange(1, steps + 1) / steps)[:, None])
    return np.concatenate(pieces)


def distance_to_path(points: NDArray[np.float32], path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each point to the nearest segment."""
    best = np.linalg.norm(points - path[0], axis=1)
    for a, b in itertools.pairwise(path):
        way = b - a
        share = np.clip((points - a) @ way / max(float(way @ way), 1e-12), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - a - share[:, None] * way, axis=1))
    return best


def overlap(truth: Labels, now: Labels) -> dict[int, float]:
    """IoU of each object of at least VISIBLE points."""
    result = {}
    for label in np.unique(truth[truth > 0]).tolist():
        is_, said = truth == label, now == label
        if int(is_.sum()) >= VISIBLE:
            result[label] = float((is_ & said).sum() / (is_ | said).sum())
    return result


def largest_patch(xyz: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Which points belong to the largest patch of touching 4 cm cells."""
    cells = np.floor(xyz / CELL).astype(np.int64)
    cells -= cells.min(axis=0)
    grid = np.zeros(cells.max(axis=0) + 1, bool)
    grid[tuple(cells.T)] = True
    numbers = connected(grid, np.ones((3, 3, 3)))[0][tuple(cells.T)]
    return np.asarray(numbers == np.bincount(numbers).argmax())


def paths_over(xyz: NDArray[np.float32], radius: float) -> list[NDArray[np.float64]]:
    """A dab in the middle of a patch, and a way along it from end to end."""
    middle = xyz.mean(axis=0, dtype=np.float64)
    dab = xyz[np.linalg.norm(xyz - middle, axis=1).argmin()].astype(np.float64)
    along = np.linalg.svd(xyz[:: max(1, len(xyz) // 500)] - middle, full_matrices=False)[2][0]
    place = (xyz - middle) @ along
    pieces = np.floor((place - place.min()) / max(radius, np.ptp(place) / 15)).astype(int)
    way = [xyz[pieces == k].mean(axis=0, dtype=np.float64) for k in np.unique(pieces)]
    return [dab[None], np.array(way)] if len(way) > 1 else [dab[None]]


def best_stroke(view: View, now: Labels, label: int) -> Stroke | None:
    """The stroke that mends most of a label's errors, None when each would do more harm."""
    missing = np.flatnonzero((view.truth == label) & (now != label))
    surplus = np.flatnonzero((view.truth != label) & (now == label))
    best: Stroke | None = None
    for tool, value, wrong in (("paint", label, missing), ("erase", 0, surplus)):
        if not wrong.size:
            continue
        patch = view.xyz[wrong[largest_patch(view.xyz[wrong])]]
        for radius in RADII:
            for path in paths_over(patch, radius):
                touched = view.swept(path, radius)
                for careful in (False, True) if tool == "paint" else (False,):
                    hit = touched[now[touched] == 0] if careful else touched
                    truth = view.truth[hit]
                    gain = int((truth == value).sum()) - int((truth == now[hit]).sum())
                    if gain > (best.gain if best else 0):
                        best = Stroke(label, tool, path, radius, gain, careful)
    return best


class Annotator:
    """Labels one sequence over REST; counts ``strokes`` and ``corrected`` frames."""

    def __init__(
        self,
        api: httpx.Client,
        sequence: str,
        truth: list[Labels],
        seed: int = 0,
        *,
        objects: bool = False,
    ) -> None:
        """``objects``: the annotator has the object tool besides the ball."""
        self._objects = objects
        self.api, self.sequence, self.truth = api, f"/sequences/{sequence}", truth
        self.frames = len(truth)
        self.strokes = 0
        self.corrected: list[int] = []
        self.tracking_seconds = 0.0
        self._rng = np.random.default_rng(seed)
        self._views: dict[int, View] = {}

    def _load(self, path: str) -> np.ndarray:
        return np.load(io.BytesIO(self.api.get(path).raise_for_status().content))

    def now(self, i: int) -> Labels:
        """The frame's labels as the server has them."""
        return self._load(f"{self.sequence}/frames/{i}/annotation")

    def view(self, i: int) -> View:
        """The frame's points with the truth."""
        if i not in self._views:
            self._views = {
                i: View(self._load(f"{self.sequence}/frames/{i}/points")["xyz"], self.truth[i])
            }
        return self._views[i]

    def quality(self, i: int) -> float:
        """Mean IoU over the frame's objects; 1 where none is visible."""
        scores = overlap(self.truth[i], self.now(i))
        return float(np.mean(list(scores.values()))) if scores else 1.0

    def paint(self, i: int, *, each: bool) -> int:
        """Work on a frame until it is good: ``each`` object, or their mean; returns strokes."""
        view, done, hopeless = self.view(i), 0, set()
        while done < MOST_STROKES:
            now = self.now(i)
            scores = overlap(view.truth, now)
            open_ = {k: s for k, s in scores.items() if s < GOAL and k not in hopeless}
            if not open_ or (not each and np.mean(list(scores.values())) >= GOAL):
                break
            worst = min(open_, key=lambda k: open_[k])
            stroke = best_stroke(view, now, worst)
            click = self._best_click(i, view, now, worst) if self._objects else None
            if click is not None and click.gain > (stroke.gain if stroke else 0):
                self._click(i, click)
            elif stroke is not None:
                self._send(i, stroke)
            else:
                hopeless.add(worst)
                continue
            done += 1
        self.strokes += done
        return done

    def _best_click(self, i: int, view: View, now: Labels, label: int) -> Click | None:
        """A click on the largest missing patch from the sensor, and the level that mends most."""
        missing = np.flatnonzero((view.truth == label) & (now != label))
        if not missing.size:
            return None
        patch = view.xyz[missing[largest_patch(view.xyz[missing])]].astype(np.float64)
        at = patch[np.linalg.norm(patch - patch.mean(axis=0), axis=1).argmin()]
        ray = {"origin": [0.0, 0.0, 0.0], "direction": at.tolist()}
        body = {"positives": [ray], "label": label, "radius": RADII[0]}
        path = f"{self.sequence}/frames/{i}/object"
        found = self.api.post(path, json=body).raise_for_status().json()["candidates"]
        best: Click | None = None
        for candidate in found:
            hit = np.concatenate([np.arange(first, first + n) for first, n in candidate["runs"]])
            hit = hit[now[hit] == 0]
            truth = view.truth[hit]
            gain = int((truth == label).sum()) - int((truth == 0).sum())
            if gain > (best.gain if best else 0):
                best = Click(label, ray, candidate["id"], gain)
        return best

    def _click(self, i: int, click: Click) -> None:
        body = {
            "id": str(uuid.UUID(bytes=self._rng.bytes(16))),
            "label": click.label,
            "shape": "object",
            "radius": RADII[0],
            "samples": [click.ray],
            "candidate": click.candidate,
        }
        self.api.post(f"{self.sequence}/frames/{i}/strokes", json=body).raise_for_status()

    def _send(self, i: int, stroke: Stroke) -> None:
        path = stroke.path + self._rng.normal(0, TREMOR, stroke.path.shape)
        body = {
            "id": str(uuid.UUID(bytes=self._rng.bytes(16))),
            "label": stroke.label,
            "tool": stroke.tool,
            "shape": "sphere",
            "radius": stroke.radius,
            "only_unlabeled": stroke.only_unlabeled,
            "samples": [{"origin": p.tolist()} for p in path],
        }
        self.api.post(f"{self.sequence}/frames/{i}/strokes", json=body).raise_for_status()

    def track(self, labels: list[int] | None, start: int, stop: int, method: str) -> None:
        """Run the tracker and wait for it."""
        begun = time.perf_counter()
        body = {"labels": labels, "start": start, "stop": stop, "method": method}
        job = self.api.post(f"{self.sequence}/tracking", json=body).raise_for_status().json()
        while job["state"] in ("queued", "running"):
            time.sleep(0.05)
            job = self.api.get(f"/jobs/{job['id']}").raise_for_status().json()
        if job["state"] != "done":
            raise RuntimeError(f"tracking {job['state']}: {job['error']}")
        self.tracking_seconds += time.perf_counter() - begun

    def label_all_by_hand(self) -> None:
        """Paint every frame without any tracking."""
        for i in range(self.frames):
            if self.paint(i, each=False):
                self.corrected.append(i)

    def label_all(self, method: str, *, forgetful: bool = False) -> None:
        """Paint frame 0, track, correct the first frame that is not good, track on from there.

        ``forgetful``: the method remembers nothing but the last frame, so that all labels are
        tracked a few frames at a time, as many as went well before, which comes to the same.
        Otherwise to the end, and again only what was corrected.
        """
        self.paint(0, each=True)
        start, labels, stretch = 0, None, 4
        while start < self.frames - 1:
            stop = min(start + stretch, self.frames - 1) if forgetful else self.frames - 1
            self.track(labels, start, stop, method)
            bad = next((i for i in range(start + 1, stop + 1) if self.quality(i) < GOAL), None)
            stretch = 2 * ((bad or stop + 1) - start)
            if bad is None:
                start, labels = stop, None
                continue
            before = overlap(self.truth[bad], self.now(bad))
            if not self.paint(bad, each=True):
                raise RuntimeError(f"frame {bad}: no stroke makes it better")
            self.corrected.append(bad)
            start = bad
            labels = None if forgetful else [k for k, s in before.items() if s < GOAL]
