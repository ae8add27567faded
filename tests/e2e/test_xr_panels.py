"""In the headset: panels take little room until they are asked for, whatever one points with."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser

from tests.e2e.conftest import DATA
from tests.e2e.headset import QUEST, VIVE, Headset, wear
from tests.e2e.inputs import Input, eyes_alone
from tests.e2e.recording import PERSON, SEQUENCE, put_dust
from tests.e2e.server import LiveServer
from tests.waiting import eventually

# A phone in portrait: one picture, 60° high and 38° wide.
PHONE = "new IWER.XRDevice({ ...IWER.metaQuest3, name: 'Phone' }, { fovy: Math.PI / 3 })"
LEFT, RIGHT = [-0.2, 1.25, -0.5], [0.26, 1.35, -0.45]
OTHER_PERSON = 8
MOST, MOST_IN_DOUBT = 0.03, 0.12
# A phone's picture is narrower than that of an eye, so the same handles take more of it.
MOST_ON_PHONE = 0.05
LEAST_CAPITAL, LEAST_TARGET = 1.0, 2.5
# Metres from the middle of a controller to the words of its hints.
LEAST_BESIDE = 0.035
# Devices on which a run is made to stop.
DOUBTING = ("quest", "one wand", "hands")

# Panels, signs and hints alone are drawn, on a colour that nothing has.
BARE = """(() => {
  const { viewer } = pb.engine, { panels, pointers, hud, tipSign } = hs.headset.cockpit;
  const words = [...panels.all.map(({ mesh }) => mesh), hud.group, tipSign.group,
    ...pointers.bodies.map(({ tips }) => tips.group)];
  viewer.scene.traverse((object) => object.layers.disableAll());
  for (const word of words) word.traverse(({ layers }) => layers.enable(0));
  viewer.renderer.setClearColor(0xff00ff, 1);
})()"""
WITHOUT_HINTS = """hs.headset.cockpit.pointers.bodies
  .forEach(({ tips }) => tips.group.traverse(({ layers }) => layers.disableAll()))"""
# Places of the headset's space, as an eye sees them: 0..1 from the upper left.
SEEN = """((eye, places) => {
  const { rig } = hs.headset.cockpit;
  const camera = pb.engine.viewer.renderer.xr.getCamera().cameras[eye];
  return places.map((place) => {
    const at = rig.head.clone().set(...place).applyMatrix4(rig.group.matrixWorld).project(camera);
    return [(at.x + 1) / 2, (1 - at.y) / 2];
  });
})"""


def hold(headset: Headset) -> None:
    headset.move("left", LEFT)
    headset.move("right", RIGHT, [0.5, 1.9, -1.5])


def with_one_wand(headset: Headset) -> None:
    hold(headset)
    headset.ask("(device.controllers.left.connected = false)")
    headset.until("hs.headset.cockpit.panels.hangs")


def with_hands(headset: Headset) -> None:
    headset.lay_down_controllers()
    hold(headset)


Call = Callable[[Headset, str], None]


def by_ray(headset: Headset, panel: str) -> None:
    headset.call(panel)
    hold(headset)


def by_press(mode: str) -> Call:
    def call(headset: Headset, panel: str) -> None:
        source = Input(headset, mode, mode, "none" if mode == "screen" else "right")
        source.call(panel)
        source.go()

    return call


def by_gaze(headset: Headset, panel: str) -> None:
    """Nothing is pressed: the head rests on the handle."""
    gaze = Input(headset, "gaze", "gaze")
    area = headset.ask(f"hs.areas('{panel}')[0]")
    gaze.move(place(headset, panel, area, 0.5, 0.5))
    headset.until(f"hs.open('{panel}')")
    gaze.go()


DEVICES = {
    "quest": (QUEST, (640, 320), hold, by_ray),
    "one wand": (VIVE, (640, 320), with_one_wand, by_ray),
    "hands": (QUEST, (640, 320), with_hands, by_ray),
    "look and pinch": (QUEST, (640, 320), eyes_alone, by_press("transient-pointer")),
    "gaze": (QUEST, (640, 320), eyes_alone, by_gaze),
    "touch": (PHONE, (400, 640), eyes_alone, by_press("screen")),
}


def place(
    headset: Headset, panel: str, area: dict[str, float], across: float, down: float
) -> list[float]:
    """A place of an area of a panel, in the headset's space."""
    u, v = area["x"] + area["w"] * across, area["y"] + area["h"] * down
    at: list[float] = headset.ask(f"hs.onPanel('{panel}', {u}, {v})")["at"]
    return at


def covered(headset: Headset) -> list[NDArray[np.bool_]]:
    """The pixels of each eye in which anything but the recording is seen."""
    shot = Image.open(io.BytesIO(headset.page.screenshot())).convert("RGB")
    other = np.abs(np.asarray(shot).astype(int) - (255, 0, 255)).max(axis=2) > 4
    eyes = headset.ask("pb.engine.viewer.renderer.xr.getCamera().cameras.length")
    return np.split(other, eyes, axis=1)


def seen(headset: Headset, eye: int, places: list[list[float]]) -> NDArray[Any]:
    return np.array(headset.ask(f"{SEEN}({eye}, {json.dumps(places)})"))


def below_the_waist(headset: Headset) -> list[list[float]]:
    """Points of both jugglers, in the headset's space."""
    with np.load(DATA / "0000.npz") as arrays:
        xyz, truth = arrays["xyz"], arrays["truth"]
    places: list[list[float]] = []
    for person in (PERSON, OTHER_PERSON):
        mine = xyz[truth == person]
        # The camera's y points down.
        low = mine[mine[:, 1] > (mine[:, 1].min() + mine[:, 1].max()) / 2][::7]
        places += headset.ask(f"{json.dumps(low.tolist())}.map((point) => hs.place(point))")
    return places


def angle(one: list[float], other: list[float], eyes: list[float]) -> float:
    a, b = np.subtract(one, eyes), np.subtract(other, eyes)
    return math.degrees(math.acos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)))


def check_hints(headset: Headset) -> None:
    """Hints are beside the hands, not over them, and in both eyes' pictures."""
    for side in ("left", "right"):
        if not headset.ask(f"hs.pointers().length > 0 && hs.tips('{side}').length > 0"):
            continue
        corners = headset.ask(
            f"""(() => {{
              const {{ pointers, rig }} = hs.headset.cockpit;
              const {{ group, box: {{ min, max }} }} = pointers.bodyOf(pointers.of('{side}')).tips;
              return [min.x, max.x].flatMap((x) => [min.y, max.y].map((y) =>
                rig.group.worldToLocal(group.localToWorld(min.clone().set(x, y, 0))).toArray()));
            }})()"""
        )
        for eye in (0, 1):
            at = seen(headset, eye, corners)
            assert ((at > 0) & (at < 1)).all(), (side, eye, at)
        beside = headset.ask(
            f"""(() => {{
              const {{ pointers }} = hs.headset.cockpit;
              const {{ box, facing }} = pointers.bodyOf(pointers.of('{side}')).tips;
              return [box.min.x, box.max.x].map((x) => Math.abs(x + facing.right));
            }})()"""
        )
        assert min(beside) > LEAST_BESIDE, (side, beside)


def check_handle(headset: Headset, panel: str) -> None:
    """A panel's handle is in both eyes' pictures, can be met and be read."""
    headset.until(f"hs.areas('{panel}').length === 1")
    (area,) = headset.ask(f"hs.areas('{panel}')")
    eyes = headset.ask("hs.headset.cockpit.rig.headInRig.toArray()")

    def at(across: float, down: float) -> list[float]:
        return place(headset, panel, area, across, down)

    for ends in (((0.5, 0), (0.5, 1)), ((0, 0.5), (1, 0.5))):
        assert angle(at(*ends[0]), at(*ends[1]), eyes) >= LEAST_TARGET
    middle = area["x"] + area["w"] / 2, area["y"] + area["h"] / 2
    assert headset.ask(f"hs.capital('{panel}', {middle[0]}, {middle[1]})") >= LEAST_CAPITAL

    def in_sight(eye: int) -> bool:
        corners = seen(headset, eye, [at(u, v) for u in (0, 1) for v in (0, 1)])
        return bool(((corners > 0) & (corners < 1)).all())

    # A hand that has just come takes its panel along once it was there for a while.
    for eye in range(headset.ask("pb.engine.viewer.renderer.xr.getCamera().cameras.length")):
        eventually(lambda eye=eye: in_sight(eye))


def check_apart(headset: Headset) -> None:
    """No eye sees one handle on the other."""
    for eye in range(headset.ask("pb.engine.viewer.renderer.xr.getCamera().cameras.length")):
        corners = []
        for panel in ("palette", "timeline"):
            (area,) = headset.ask(f"hs.areas('{panel}')")
            ends = [place(headset, panel, area, u, v) for u in (0, 1) for v in (0, 1)]
            corners.append(seen(headset, eye, ends))
        one, other = corners
        assert (
            (one.max(axis=0) < other.min(axis=0)) | (other.max(axis=0) < one.min(axis=0))
        ).any(), corners


def check_words(headset: Headset, panel: str) -> None:
    """Words in every corner of a panel, and all that answers on it, are large enough."""
    eyes = headset.ask("hs.headset.cockpit.rig.headInRig.toArray()")
    for u, v in ((0.03, 0.04), (0.97, 0.04), (0.03, 0.96), (0.97, 0.96)):
        assert headset.ask(f"hs.capital('{panel}', {u}, {v})") >= LEAST_CAPITAL
    for area in headset.ask(f"hs.areas('{panel}')"):
        for ends in (((0.5, 0), (0.5, 1)), ((0, 0.5), (1, 0.5))):
            one, other = (place(headset, panel, area, *end) for end in ends)
            assert angle(one, other, eyes) >= LEAST_TARGET, area["name"]


def check_doubt(headset: Headset, server: LiveServer, begin: Callable[[Headset], None]) -> None:
    """A run that stops asks in little of the picture, in words and with answers of a good size."""
    put_dust(server)
    headset.until("pb.state.timeline.value.rows.get(1)?.points[0] === 60")
    headset.click("timeline", "To end")
    headset.until("hs.doubt().halted !== null && hs.open('question')")
    begin(headset)
    folded = "!hs.open('palette') && !hs.open('timeline') && hs.areas('question').length > 2"
    headset.until(folded)
    check_words(headset, "question")
    headset.ask(BARE)
    headset.ask(WITHOUT_HINTS)
    headset.ask("pb.setDrawing(true)")
    headset.frames(3)
    for hidden in covered(headset):
        assert 0.01 < hidden.mean() <= MOST_IN_DOUBT
    headset.ask("pb.setDrawing(false)")
    # The first minute waits until the question is answered.
    headset.click("palette", "Comfort")
    headset.click("palette", "First minute")
    headset.until("hs.taught() !== null")
    assert headset.ask("hs.headset.cockpit.panels.added.mesh.visible") is False
    headset.click("question", "Later")
    headset.until("hs.headset.cockpit.panels.added.mesh.visible")


@pytest.mark.parametrize("name", DEVICES)
def test_panels_take_little_room_until_they_are_called(
    browser: Browser, server: LiveServer, name: str
) -> None:
    device, size, begin, call = DEVICES[name]
    server.create_label(SEQUENCE, "person", "#ff5d5d")
    headset = wear(browser, server.page_url, device, size=size, drawn=True)
    headset.ready()
    headset.enter()
    begin(headset)
    low = below_the_waist(headset)
    headset.ask(BARE)
    headset.ask("pb.setDrawing(true)")
    headset.frames(3)
    for panel in ("palette", "timeline"):
        check_handle(headset, panel)
    check_apart(headset)
    check_hints(headset)
    # A message about a controller that has gone is not for long.
    headset.until("!hs.headset.cockpit.hud.group.children[0].visible")
    headset.frames(2)
    for hidden in covered(headset):
        assert 0.001 < hidden.mean() <= (MOST_ON_PHONE if name == "touch" else MOST)
    # Hints go once they are learnt: panels alone never hide what is to be painted.
    headset.ask(WITHOUT_HINTS)
    headset.frames(2)
    for eye, hidden in enumerate(covered(headset)):
        x, y = (seen(headset, eye, low) * hidden.shape[::-1]).astype(int).T
        inside = (x >= 0) & (x < hidden.shape[1]) & (y >= 0) & (y < hidden.shape[0])
        assert hidden[y[inside], x[inside]].sum() <= 0.02 * len(low)
    headset.ask("pb.setDrawing(false)")
    call(headset, "timeline")
    # Nothing points at it any more, and one looks ahead.
    check_handle(headset, "timeline")
    call(headset, "palette")
    check_words(headset, "palette")
    if name in DOUBTING:
        check_doubt(headset, server, begin)
    headset.close()
    assert headset.complaints == []
