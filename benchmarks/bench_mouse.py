"""A scripted mouse labels the sample recording, and a street that a lidar sees, on the real page.

python benchmarks/bench_mouse.py [sample|street ...] [--frames 90] [--ways brush,tools]

A server of its own, Chromium, and events of mouse and keyboard: the truth says where to point, the
rest is done as by a person.  Each scene is labelled twice.  ``brush``: with the ball alone.
``tools``: pins by the object tool, with its wheel and further clicks; the ground by the ground
tool, cars by a lasso from above.  Both are tracked on by the form, and corrected in the first frame
that is not good, a few times.  Goal: a mean IoU of 0.9 for every label.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from annotator import GOAL, VISIBLE, Labels, View, best_stroke, overlap
from bench_effort import TOKEN, add, serving
from object_clicks import middle, next_click
from playwright.sync_api import Browser, sync_playwright
from scipy.spatial import ConvexHull

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "tracking")]

from mouse_hand import Hand  # noqa: E402
from scenes.street import street  # noqa: E402

from pointbrush.frame import PointFrame  # noqa: E402
from pointbrush.samples import generate  # noqa: E402
from tests.e2e.chromium import EXECUTABLE, FLAGS  # noqa: E402
from tests.e2e.desk import launch  # noqa: E402

WAYS = ("brush", "tools")
MOST_STROKES = 8
"""Strokes of the ball for a label in a frame, after which it is left as it is."""
MOST_CLICKS = 4
"""Clicks of the object tool for a label in a frame."""
MOST_ROUNDS = 3
"""Frames that are corrected after the first tracking."""
STREET_FRAMES = 5
GROUND = 30
"""The ground's label; cars have 1 to 7."""
ROUGH = 0.06
"""Metres that the lidar's points of the ground are at most off the height 0."""
COLORS = ("#d8342b", "#1f6fc4", "#f0b51f", "#2f9a4c", "#8a3fa8", "#e8702a", "#2fd5e0", "#c46fa0")
LIDAR_SCALE = 10.0
"""Balls and cells of the annotator, which are made for depth cameras, times this."""
REACH = 1.0
"""Metres of the ground tool: half of the gaps between the lidar's rings that it bridges."""
LASSO_MARGIN = 5.0
"""Pixels that a lasso stays away from what it goes round."""
MOST_SEEN = 150
"""Points of an object whose places on screen are looked at before it is gone round."""


@dataclass(eq=False)
class Scene:
    """A recording with the truth of its labels."""

    name: str
    frames: list[PointFrame]
    truth: list[Labels]
    names: dict[int, str]
    fps: float
    scale: float = 1.0
    """How much larger its things are than those before a depth camera."""
    plan: bool = False
    """Whether it is looked at from above."""
    moving: list[int] = field(default_factory=list)
    """Labels that are tracked; the others are labelled in every frame."""


def sample(count: int) -> Scene:
    """The sample recording: two jugglers pass six pins; the pins are to be labelled."""
    made = generate("juggling", 0, count)
    frames, truth = [], []
    names = {label.id: label.name for label in made.labels if label.category == "pin"}
    for i in range(count):
        frames.append(made.frame(i))
        truth.append(np.where(np.isin(made.truth[i], list(names)), made.truth[i], 0))
    return Scene("sample", frames, truth, names, made.fps, moving=list(names))


def lidar() -> Scene:
    """A street from a car: cars are tracked, the ground is taken in every frame."""
    frames, truth = [], []
    for seen in street(0, STREET_FRAMES):
        height = seen.xyz[:, 1] + seen.pose[1, 3]
        is_ground = (seen.truth == 0) & (np.abs(height) < ROUGH)
        labels = np.where(seen.truth < 20, seen.truth, 0)
        truth.append(np.where(is_ground, GROUND, labels).astype(np.uint16))
        frames.append(PointFrame(seen.xyz, intensity=seen.intensity, pose=seen.pose))
    numbers, counts = np.unique(truth[0], return_counts=True)
    cars = [int(n) for n, c in zip(numbers, counts, strict=True) if 0 < n < 20 and c >= VISIBLE]
    names = {GROUND: "ground"} | {car: f"car {car}" for car in cars}
    truth = [np.where(np.isin(one, list(names)), one, 0).astype(np.uint16) for one in truth]
    return Scene("street", frames, truth, names, 10.0, LIDAR_SCALE, plan=True, moving=cars)


class Person:
    """Labels one scene with a hand, by the ball alone or by the tools for the purpose."""

    def __init__(self, hand: Hand, scene: Scene, ids: dict[int, int], way: str) -> None:
        """``ids``: label of the truth → label of the server."""
        self.hand, self.scene, self.way, self.ids = hand, scene, way, ids
        largest = max(scene.names) + 1
        self._named = np.zeros(largest, np.uint16)
        for truth, label in ids.items():
            self._named[truth] = label
        self.corrected: list[int] = []

    def truth(self, frame: int) -> Labels:
        """The frame's truth in the server's numbers."""
        return self._named[self.scene.truth[frame]]

    def iou(self, frame: int) -> dict[int, float]:
        """IoU of each label that is to be seen in a frame."""
        return overlap(self.truth(frame), self.hand.labels(frame))

    # ── a frame ──────────────────────────────────────────────────────────────────────────

    def by_ball(self, frame: int, label: int) -> None:
        """Strokes where they mend most, until the label is good."""
        hand, scale = self.hand, self.scene.scale
        view = View(hand.points(frame) / np.float32(scale), self.truth(frame))
        before = -1.0
        for _ in range(MOST_STROKES):
            now = hand.labels(frame)
            score = overlap(view.truth, now).get(label, 1.0)
            stroke = best_stroke(view, now, label) if before < score < GOAL else None
            if stroke is None:
                return
            before = score
            hand.choose(label)
            hand.tool(stroke.tool, "brush", "b")
            hand.size(stroke.radius * scale)
            if stroke.tool == "paint":
                hand.check("Only unlabelled", on=stroke.only_unlabeled)
            hand.drag(stroke.path * scale)

    def by_object(self, frame: int, label: int) -> None:
        """A click, the level that fits, and clicks on what is still wrong; then the ball."""
        hand, xyz, wanted = self.hand, self.hand.points(frame), self.truth(frame) == label
        hand.choose(label)
        hand.tool("paint", "object", "j")
        hand.key("Escape")
        hand.point_at(middle(xyz, wanted))
        hand.desk.until("pb.state.object.value?.ready")
        self._fit(int(wanted.sum()))
        hand.click()
        for _ in range(MOST_CLICKS - 1):
            mask = hand.labels(frame) == label
            after = next_click(xyz, wanted, mask)
            if after is None or overlap(self.truth(frame), hand.labels(frame))[label] >= GOAL:
                break
            place, adds = after
            hand.point_at(place)
            hand.click(removes=not adds)
        hand.key("Escape")
        self.by_ball(frame, label)

    def _fit(self, points: int) -> None:
        """Turn the wheel to the level whose size is nearest to what the eye expects."""
        for step in (1, -1):
            while (shown := self.hand.offered) is not None:
                if not 0 <= shown["level"] + step < shown["levels"]:
                    break
                self.hand.wheel(step)
                after = self.hand.offered
                if after is None or abs(after["points"] - points) >= abs(shown["points"] - points):
                    self.hand.wheel(-step)
                    break

    def by_lasso(self, frame: int, label: int) -> None:
        """An outline round it, seen from above; the ground is taken already and stays."""
        hand, wanted = self.hand, self.truth(frame) == label
        places = hand.points(frame)[wanted]
        shown = places[:: -(-len(places) // MOST_SEEN)].tolist()
        seen = np.array([hand.desk.place(place) for place in shown])
        hand.choose(label)
        hand.tool("paint", "lasso", "o")
        hand.check("Only unlabelled", on=True)
        corners = seen[ConvexHull(seen).vertices]
        away = corners - seen.mean(axis=0)
        hand.outline(corners + LASSO_MARGIN * away / np.linalg.norm(away, axis=1, keepdims=True))
        self.by_ball(frame, label)

    def by_plane(self, frame: int, label: int) -> None:
        """Clicks on the ground, near the middle of what is missing; then the ball."""
        hand, truth, xyz = self.hand, self.truth(frame), self.hand.points(frame)
        hand.choose(label)
        hand.tool("paint", "plane", "g")
        hand.size(REACH)
        hand.check("Only unlabelled", on=True)
        for _ in range(MOST_CLICKS):
            now = hand.labels(frame)
            if overlap(truth, now).get(label, 1.0) >= GOAL:
                return
            missing = (truth == label) & (now != label)
            away = np.linalg.norm(xyz - np.median(xyz[missing], axis=0), axis=1)
            hand.point_at(middle(xyz, missing & (away <= np.median(away[missing]))))
            hand.click()
        self.by_ball(frame, label)

    def label(self, frame: int, label: int) -> None:
        """Label one thing in a frame, by what this person has for it."""
        tools = self.by_lasso if self.scene.plan else self.by_object
        if self.way == "brush":
            self.by_ball(frame, label)
        elif label == self.ids.get(GROUND):
            self.by_plane(frame, label)
        else:
            tools(frame, label)

    # ── a recording ──────────────────────────────────────────────────────────────────────

    def label_all(self) -> None:
        """The first frame, tracking, the first frame that is not good, and so on."""
        begun = time.perf_counter()
        hand, last = self.hand, len(self.scene.frames) - 1
        moving = [self.ids[label] for label in self.scene.moving]
        still = [label for label in self.ids.values() if label not in moving]
        hand.go(0)
        if self.scene.plan:
            hand.look_down(np.isin(self.truth(0), moving))
        for label in [*still, *moving]:
            if label in self.iou(0):
                self.label(0, label)
        self._track(moving, last)
        start = 1
        for _ in range(MOST_ROUNDS):
            found = self._first_bad(start, moving)
            if found is None:
                break
            start, bad = found
            self.corrected.append(start)
            hand.go(start)
            for label in bad:
                self.label(start, label)
            if start < last:
                self._track(bad, last)
            start += 1
        for frame in range(1, last + 1) if still else ():
            hand.go(frame)
            for label in still:
                self.label(frame, label)
        hand.work.seconds += time.perf_counter() - begun

    def _track(self, labels: list[int], stop: int) -> None:
        names = {self.ids[label]: name for label, name in self.scene.names.items()}
        self.hand.track(labels, names, stop)

    def _first_bad(self, start: int, labels: list[int]) -> tuple[int, list[int]] | None:
        """The first frame that is not good, and its labels to be corrected."""
        for frame in range(start, len(self.scene.frames)):
            scores = {label: s for label, s in self.iou(frame).items() if label in labels}
            if scores and np.mean(list(scores.values())) < GOAL:
                return frame, [label for label, s in scores.items() if s < GOAL]
        return None


def pooled(person: Person) -> dict[str, float]:
    """IoU of each label over all points of all frames."""
    both, either = dict.fromkeys(person.ids, 0), dict.fromkeys(person.ids, 0)
    for frame in range(len(person.scene.frames)):
        truth, now = person.truth(frame), person.hand.labels(frame)
        for name, label in person.ids.items():
            both[name] += int(((truth == label) & (now == label)).sum())
            either[name] += int(((truth == label) | (now == label)).sum())
    names = person.scene.names
    return {names[k]: both[k] / max(either[k], 1) for k in person.ids}


def report(person: Person) -> None:
    """Print what it took, and what came of it."""
    work, scores = person.hand.work, pooled(person)
    fixed = ", ".join(map(str, person.corrected)) or "none"
    print(
        f"  {person.scene.name:7} {person.way:6} {work.strokes:7} {work.clicks:7} {work.notches:7}"
        f" {work.keys:6} {work.seconds:9.0f} {work.tracking:9.0f}"
        f"   {min(scores.values()):.3f} {np.mean(list(scores.values())):.3f}   frames {fixed}"
    )
    print("    " + ", ".join(f"{name} {score:.3f}" for name, score in scores.items()), flush=True)


def work_on(browser: Browser, workspace: Path, scene: Scene, way: str) -> None:
    """Label a scene on a server of its own."""
    with serving(workspace) as api:
        ids = {}
        for k, (label, name) in enumerate(scene.names.items()):
            body = {"name": name, "color": COLORS[k % len(COLORS)]}
            answer = api.post(f"/sequences/{scene.name}/labels", json=body).raise_for_status()
            ids[label] = answer.json()["id"]
        url = f"{api.base_url.copy_with(path='/')}?token={TOKEN}&sequence={scene.name}"
        desk = launch(browser, url)
        try:
            desk.ready()
            person = Person(Hand(desk, api, scene.name), scene, ids, way)
            person.label_all()
            report(person)
            if desk.complaints:
                raise RuntimeError(f"the page complained: {desk.complaints}")
        finally:
            desk.close()


def main() -> None:
    """Print a line for each scene and way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=["sample", "street"])
    parser.add_argument("--frames", type=int, default=90, help="of the sample recording")
    parser.add_argument("--ways", default=",".join(WAYS))
    given = parser.parse_args()
    print("  scene   way    strokes  clicks notches   keys  labelling  tracking   IoU: least mean")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=EXECUTABLE, args=FLAGS)
        for name in given.scenes:
            scene = sample(given.frames) if name == "sample" else lidar()
            made = Path(folder) / name
            add(scene.frames, scene.fps, made, name)
            for way in given.ways.split(","):
                workspace = made.with_name(f"{name}-{way}")
                shutil.copytree(made, workspace)
                work_on(browser, workspace, scene, way)
        browser.close()


if __name__ == "__main__":
    main()
