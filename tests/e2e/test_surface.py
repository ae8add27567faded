"""Depth images as surfaces: fewer holes than points, and the same labels."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, name_person
from tests.e2e.server import LiveServer

Picture = NDArray[np.uint8]
View = dict[str, object]

READ = """(() => {
  const { renderer, eyeDome } = pb.engine.viewer;
  const { target } = eyeDome;
  const pixels = new Uint8Array(4 * target.width * target.height);
  renderer.readRenderTargetPixels(target, 0, 0, target.width, target.height, pixels);
  let text = '';
  for (let i = 0; i < pixels.length; i += 8192)
    text += String.fromCharCode(...pixels.subarray(i, i + 8192));
  return [target.width, target.height, btoa(text)];
})()"""
"""The picture of the cloud alone, before it is shaded: alpha is 0 in the background."""
IMAGE = """(() => {
  const { room, camera } = pb.engine.viewer;
  const { lattice, depths } = pb.engine.playback.frame.images[0];
  const clip = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse);
  return [lattice, [...depths], clip.multiply(room.matrixWorld).elements];
})()"""
MODES = ("points", "surface")
VISIBLE = 24
"""Difference of a colour, of 255, from which two pixels count as different."""
WINDOW = 5
"""Pixels along each side of the surroundings that tell whether a surface is smooth."""
LEAST_POINTS, STEEPEST = 18, 6.0
"""Points of the surroundings, and the greatest difference of their depths, in distances between
neighbours."""
FINE = 10
"""Places of a cell between four pixels that are looked at, along each side."""


def smooth(desk: Desk, height: int, width: int) -> NDArray[np.bool_]:
    """Pixels of the picture (height, width) that smooth surfaces cover."""
    lattice, values, elements = desk.ask(IMAGE)
    depths = np.array(values, float).reshape(lattice["height"], lattice["width"])
    depths[depths == 0] = np.nan
    padded = np.pad(depths, WINDOW // 2, constant_values=np.nan)
    around = np.lib.stride_tricks.sliding_window_view(padded, (WINDOW, WINDOW))
    around = around.reshape(*depths.shape, -1)
    enough = np.isfinite(around).sum(-1) >= LEAST_POINTS
    around = np.where(enough[..., None], around, 0.0)
    middle = np.nanmedian(around, -1)
    reach = np.nanmax(around, -1) - np.nanmin(around, -1)
    fits = enough & (reach < STEEPEST * lattice["pitch"][0] * middle)
    cells = fits[:-1, :-1] & fits[1:, :-1] & fits[:-1, 1:] & fits[1:, 1:]
    row, column = np.nonzero(cells)
    covered = np.zeros((height, width), bool)
    clip = np.array(elements).reshape(4, 4).T
    for step in np.ndindex(FINE, FINE):
        down, across = (np.array(step) + 0.5) / FINE
        depth = np.zeros(len(row))
        for i, k in np.ndindex(2, 2):
            share = (down if i else 1 - down) * (across if k else 1 - across)
            depth += share * middle[row + i, column + k]
        along = lattice["unit"] * depth
        x, y = (
            along * (lattice["tangent"][i] + lattice["pitch"][i] * place)
            for i, place in enumerate((column + across, row + down))
        )
        u, v, _, w = clip @ [x, y, lattice["sign"] * along, np.ones_like(x)]
        left, up = (u / w + 1) / 2 * width, (v / w + 1) / 2 * height
        seen = (w > 0) & (left >= 0) & (left < width) & (up >= 0) & (up < height)
        covered[up[seen].astype(int), left[seen].astype(int)] = True
    return covered


def picture(desk: Desk, **view: object) -> Picture:
    """The cloud's pixels (height, width, 4) once it is drawn with these settings."""
    view["eyeDome"] = True
    seen = desk.ask(
        f"(pb.state.view.value = {{ ...pb.state.view.value, ...{json.dumps(view)} }}, "
        "pb.engine.viewer.invalidate(), pb.counters().pictures)"
    )
    desk.until(f"pb.counters().pictures > {seen}")
    width, height, text = desk.ask(READ)
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)


def look_at(desk: Desk, middle: list[float], distance: float) -> None:
    """Look at a place of the recording from somewhat beside the camera's line of sight."""
    desk.ask(
        f"""(() => {{
          const {{ room, camera }} = pb.engine.viewer;
          const at = camera.position.clone().set(...{middle}).applyMatrix4(room.matrixWorld);
          const way = camera.position.clone().set(0, 0, 0).applyMatrix4(room.matrixWorld).sub(at);
          way.normalize().applyAxisAngle(camera.up, 0.35).multiplyScalar({distance}).add(at);
          pb.look(way.toArray(), at.toArray());
        }})()"""
    )


def test_a_surface_has_fewer_holes_and_the_same_labels(
    open_desk: Callable[..., Desk], server: LiveServer, truth: Truth
) -> None:
    desk = open_desk(drawn=True)
    desk.ask("pb.setAdaptive(false)")
    desk.page.get_by_role("button", name="Overlays").click()
    for mode, drawn in (("Surface", "true"), ("Points", "false")):
        desk.page.get_by_role("radio", name=mode, exact=True).click()
        desk.until(f"pb.engine.viewer.hasSurface === {drawn}")
    desk.press("Escape")
    person = truth(0, PERSON)
    for distance in (1.0, 2.0, 4.0):
        look_at(desk, person, distance)
        points, surface = (
            picture(desk, surface=mode)[..., 3] > 0 for mode in ("points", "surface")
        )
        inside = smooth(desk, *points.shape)
        assert inside.sum() > 20_000
        left, before = ((inside & ~drawn).sum() for drawn in (surface, points))
        print(f"{distance:.0f} m: {left} holes, {before} with points")
        assert left <= before / 4, distance
    # What follows needs no fine picture, and drawing takes most of the time.
    desk.page.set_viewport_size({"width": 960, "height": 540})
    name_person(desk, server)
    look_at(desk, person, 2.0)
    labels = np.zeros(desk.ask("pb.shown().total"), np.uint16)
    xyz = server.points(SEQUENCE, 0)
    labels[np.linalg.norm(xyz - person, axis=1) < 0.4] = 1
    server.put_annotation(SEQUENCE, 0, labels)
    desk.until(f"pb.drawnLabels()[1] === {(labels == 1).sum()}")
    red = [is_red(picture(desk, surface=mode, color="label")).sum() for mode in MODES]
    assert red[0] > 1000
    assert 0.75 < red[1] / red[0] < 1.25
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/1", json={"visible": False})
    desk.until("pb.state.palette.value[0].visible === false")
    for mode in MODES:
        assert is_red(picture(desk, surface=mode)).sum() == 0
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/1", json={"visible": True})
    desk.until("pb.state.palette.value[0].visible === true")
    each_level(desk)
    alike(desk, "confidence", {"color": "plain"}, {"color": "confidence"})
    deleted(desk, server, xyz, person)
    painting(desk, xyz, person)
    playing(desk)


def changed(desk: Desk, mode: str, before: View, after: View) -> Picture:
    """Pixels that two settings show in different colours, drawn in a mode."""
    one, other = (picture(desk, surface=mode, **view).astype(int) for view in (before, after))
    found: Picture = (np.abs(one - other)[..., :3].max(-1) > VISIBLE) & (other[..., 3] > 0)
    return found


def alike(desk: Desk, what: str, before: View, after: View) -> None:
    """Two settings differ in the same pixels as points and as a surface."""
    points, surface = (changed(desk, mode, before, after) for mode in MODES)
    print(f"{what}: {points.sum()} pixels of points, {surface.sum()} of the surface")
    assert points.sum() > 500, what
    assert (points & surface).sum() > 0.75 * points.sum(), what
    assert (points & surface).sum() > 0.6 * surface.sum(), what


def each_level(desk: Desk) -> None:
    """Labels and surfaces are there at each level of decimation."""
    pieces = desk.ask(
        "pb.engine.playback.frame.pieces.map(({ level, first, count }) => [level, first + count])"
    )
    ends = sorted(dict(pieces).values())
    whole = picture(desk, surface="surface", color="label")
    # The page draws a still picture whole: here the test sets the limit.
    desk.ask("(pb.engine.pacing.update = () => undefined)")
    for end in ends:
        desk.ask(f"pb.engine.viewer.setLimit({end})")
        drawn = picture(desk, surface="surface", color="label")
        assert desk.ask("pb.shown().drawn") == end
        print(f"{end} points: {(drawn[..., 3] > 0).sum()} pixels, {is_red(drawn).sum()} labelled")
        assert (drawn[..., 3] > 0).sum() > 0.75 * (whole[..., 3] > 0).sum(), end
        assert 0.6 < is_red(drawn).sum() / is_red(whole).sum() < 1.4, end
    desk.ask("delete pb.engine.pacing.update")


def deleted(desk: Desk, server: LiveServer, xyz: NDArray[np.float64], person: list[float]) -> None:
    """Deleted points are shown or left out in the same places."""
    gone = np.linalg.norm(xyz - person, axis=1) < 0.15
    stream = BytesIO()
    np.save(stream, gone)
    path = f"sequences/{SEQUENCE}/frames/0/annotation?layer=deleted"
    headers = {"Content-Type": "application/x-npy"}
    server.request("PUT", path, content=stream.getvalue(), extra=headers)
    desk.until(f"pb.labels(0)[-1] === {gone.sum()}")
    plain = {"color": "plain"}
    alike(desk, "deleted", plain | {"showDeleted": False}, plain | {"showDeleted": True})


def painting(desk: Desk, xyz: NDArray[np.float64], person: list[float]) -> None:
    """The brush and the stroke under way are previewed in the same pixels."""
    away = np.linalg.norm(xyz - person, axis=1)
    at = xyz[np.flatnonzero((away > 0.5) & (away < 0.55))[0]].tolist()
    desk.page.get_by_role("radio", name="Brush").click()
    desk.paint([at], release=False)
    for mode in MODES:
        picture(desk, surface=mode)
        desk.page.mouse.move(*desk.place(at))
        desk.until("Object.keys(pb.drawnLabels()).length > 1")
    alike_now = [is_red(picture(desk, surface=mode, color="label")).sum() for mode in MODES]
    desk.page.mouse.up()
    desk.settled()
    print(f"preview: {alike_now}")
    assert 0.75 < alike_now[1] / alike_now[0] < 1.25


def playing(desk: Desk) -> None:
    """The surface stays while the recording plays."""
    whole = (picture(desk, surface="surface")[..., 3] > 0).sum()
    desk.ask("pb.engine.playback.play()")
    desk.until("pb.shown().frame > 0")
    moving = (picture(desk)[..., 3] > 0).sum()
    assert desk.ask("[pb.state.playing.value, pb.engine.viewer.hasSurface]") == [True, True]
    desk.ask("pb.engine.playback.pause()")
    assert moving > 0.85 * whole


def is_red(pixels: Picture) -> NDArray[np.bool_]:
    """Pixels in the label's colour, light or dark."""
    r, g, b, a = np.moveaxis(pixels.astype(int), -1, 0)
    found: NDArray[np.bool_] = (a > 0) & (r > 1.8 * g) & (r > 1.8 * b)
    return found
