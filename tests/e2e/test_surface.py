"""Depth images as surfaces: fewer holes than points, and the same labels."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tests.e2e.desk import Desk
from tests.e2e.recording import PERSON, SEQUENCE, Truth, name_person
from tests.e2e.server import LiveServer

Picture = NDArray[np.uint8]

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
  const { lattice, depths } = pb.engine.playback.frame.image;
  const clip = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse);
  return [lattice, [...depths], clip.multiply(room.matrixWorld).elements];
})()"""
WINDOW = 5
"""Pixels along each side of the surroundings that tell whether a surface is smooth."""
LEAST_POINTS, STEEPEST = 18, 6.0
"""Points of the surroundings, and the greatest difference of their depths, in distances between
neighbours."""
FINE = 16
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
    # Coarse levels cover the same surfaces.
    whole = surface.sum()
    desk.ask("pb.engine.viewer.setLimit(16_000)")
    assert (picture(desk)[..., 3] > 0).sum() > 0.85 * whole
    desk.ask("pb.engine.viewer.setLimit(1e9)")

    name_person(desk, server)
    look_at(desk, person, 2.0)
    labels = np.zeros(desk.ask("pb.shown().total"), np.uint16)
    xyz = server.points(SEQUENCE, 0)
    labels[np.linalg.norm(xyz - person, axis=1) < 0.4] = 1
    server.put_annotation(SEQUENCE, 0, labels)
    desk.until(f"pb.drawnLabels()[1] === {(labels == 1).sum()}")
    red = [
        is_red(picture(desk, surface=mode, color="label")).sum() for mode in ("points", "surface")
    ]
    assert red[0] > 1000
    assert 0.75 < red[1] / red[0] < 1.25
    server.request("PATCH", f"sequences/{SEQUENCE}/labels/1", json={"visible": False})
    desk.until("pb.state.palette.value[0].visible === false")
    for mode in ("points", "surface"):
        assert is_red(picture(desk, surface=mode)).sum() == 0


def is_red(pixels: Picture) -> NDArray[np.bool_]:
    """Pixels in the label's colour, light or dark."""
    r, g, b, a = np.moveaxis(pixels.astype(int), -1, 0)
    found: NDArray[np.bool_] = (a > 0) & (r > 1.8 * g) & (r > 1.8 * b)
    return found
