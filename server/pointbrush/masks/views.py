"""Projection of points into pictures: the pixel and the depth of each point of a frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pointbrush.errors import BadInputError
from pointbrush.values.frames import Camera

FISHEYE = ("equidistant", "fisheye", "kannala_brandt4")
POLYNOMIAL = ("", "plumb_bob", "rational_polynomial", "radtan")
"""Names of the models of lenses that OpenCV and ROS use."""
NEAREST = 0.05
"""Least depth of a point in a picture, metres."""
RADIUS_STEP = 0.05
"""Step of the search for the radius at which a distortion stops growing, in focal lengths."""
MOST_RADIUS = 5.0
"""End of this search, in focal lengths."""
BLOCK = 1 << 20
"""Points projected at once."""

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """N points of a frame in a picture of ``height`` by ``width`` pixels.

    ``pixel``  (N,) int32 row-major pixel of each point, -1 outside of the picture.
    ``depth``  (N,) float32 metres along the optical axis.
    ``uv``     (N, 2) float32 exact column and row, or None for a lattice.
    ``focal``  focal length, and ``centre`` the principal point, pixels; 0 for a lattice.
    ``exact``  True for the pixels that the points were measured in: no point hides another.
    """

    name: str
    width: int
    height: int
    pixel: NDArray[np.int32]
    depth: NDArray[np.float32]
    uv: NDArray[np.float32] | None = None
    focal: float = 0.0
    centre: tuple[float, float] = (0.0, 0.0)
    exact: bool = False

    @classmethod
    def of_camera(cls, camera: Camera, xyz: Floats) -> View:
        """Project points (N, 3), source coordinates, into a camera.

        A pixel (u, v) covers half a pixel around its centre, as in OpenCV.
        Raises BadInputError if the calibration or the model of the lens is not known.
        """
        lens = Lens.of(camera)
        size, count = (camera.width, camera.height), len(xyz)
        pixel, depth = np.full(count, -1, np.int32), np.empty(count, np.float32)
        places = np.empty((count, 2), np.float32)
        for first in range(0, count, BLOCK):
            part = slice(first, first + BLOCK)
            uv, depth[part], seen = lens.project(xyz[part])
            places[part] = uv
            pixel[part] = np.where(seen, pixel_at(uv, size), -1)
        centre = (float(lens.K[0, 2]), float(lens.K[1, 2]))
        return cls(camera.name, *size, pixel, depth, places, lens.focal, centre)

    @classmethod
    def of_lattice(
        cls, name: str, size: tuple[int, int], pixel: NDArray[Any], depth: Floats
    ) -> View:
        """Return the view of the depth camera that measured the points.

        ``size``: width and height; ``pixel`` (N,) row-major, ``depth`` (N,) metres.
        """
        width, height = size
        return cls(
            name, width, height, pixel.astype(np.int32), depth.astype(np.float32), exact=True
        )

    def moved(self, offset: NDArray[np.float64]) -> View:
        """Return the view from a camera that moved so that points shift by ``offset`` (3,) metres.

        ``offset`` is along the camera's axes; its effect is linearised.  Points outside of the
        picture stay outside.
        """
        assert self.uv is not None  # noqa: S101 – only cameras are moved
        shift = self.focal * offset[:2] - (self.uv - np.array(self.centre, np.float32)) * offset[2]
        uv = self.uv + shift / self.depth[:, None]
        pixel = pixel_at(uv, (self.width, self.height))
        return replace(self, uv=uv, pixel=np.where(self.pixel >= 0, pixel, -1))

    def only(self, numbers: NDArray[np.int64]) -> View:
        """Return the view of the points with these numbers (n,)."""
        uv = None if self.uv is None else self.uv[numbers]
        return replace(self, pixel=self.pixel[numbers], depth=self.depth[numbers], uv=uv)

    def without(self, removed: NDArray[np.bool_]) -> View:
        """Return the view with the points that ``removed`` (N,) marks outside of the picture."""
        return replace(self, pixel=np.where(removed, np.int32(-1), self.pixel))

    @property
    def seen(self) -> NDArray[np.int64]:
        """Numbers of the points in the picture, increasing."""
        return np.flatnonzero(self.pixel >= 0)

    def require_mask(self, mask: NDArray[Any]) -> None:
        """Raise BadInputError unless a mask has the size of the picture."""
        if mask.shape != (self.height, self.width):
            size = "x".join(map(str, reversed(mask.shape)))
            raise BadInputError(
                f"mask: expected {self.width}x{self.height} pixels as camera {self.name!r} has, "
                f"got {size}"
            )


def pixel_at(uv: Floats, size: tuple[int, int]) -> NDArray[np.int32]:
    """Return row-major pixels (N,) of columns and rows (N, 2), -1 outside of width and height."""
    width = size[0]
    at = np.floor(np.clip(uv, -1, max(size)) + 0.5)
    inside = ((at >= 0) & (at < size)).all(axis=1)
    return np.where(inside, at[:, 1] * width + at[:, 0], -1).astype(np.int32)


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """A camera's lens by the models of OpenCV and ROS, as in ``cameras/lens.ts`` of the page."""

    K: NDArray[np.float64]
    T_camera_frame: NDArray[np.float64]
    distortion: NDArray[np.float64]
    fisheye: bool

    @classmethod
    def of(cls, camera: Camera) -> Lens:
        """Return the lens of a camera; raises BadInputError for an unknown calibration or model."""
        missing = [name for name in ("K", "T_camera_frame") if getattr(camera, name) is None]
        if missing:
            raise BadInputError(
                f"camera {camera.name!r}: expected a calibration, its {missing[0]} is not known"
            )
        stated = np.asarray(camera.distortion, np.float64)
        if camera.model not in (*FISHEYE, *POLYNOMIAL) and stated.any():
            known = ", ".join((*FISHEYE, *POLYNOMIAL[1:]))
            raise BadInputError(
                f"camera {camera.name!r}: expected a lens of {known}, got {camera.model!r}"
            )
        coefficients = np.zeros(max(8, len(stated)))
        coefficients[: len(stated)] = stated
        fisheye = camera.model in FISHEYE and len(stated) > 0
        return cls(
            np.asarray(camera.K, np.float64),
            np.asarray(camera.T_camera_frame, np.float64),
            coefficients,
            fisheye,
        )

    @property
    def focal(self) -> float:
        """Focal length, pixels."""
        return float(self.K[0, 0] + self.K[1, 1]) / 2

    def project(
        self, xyz: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Return pixels (N, 2), depths (N,) metres and whether the lens sees the points (N, 3)."""
        local = np.asarray(xyz, np.float64) @ self.T_camera_frame[:3, :3].T
        local += self.T_camera_frame[:3, 3]
        depth = local[:, 2]
        seen = depth >= NEAREST
        flat = local[:, :2] / np.where(seen, depth, 1.0)[:, None]
        if not self.fisheye:
            seen &= (flat**2).sum(axis=1) <= self._reach()
        flat[~seen] = 0.0
        bent = self._distort(flat) @ self.K[:2, :2].T + self.K[:2, 2]
        return bent, depth, seen

    def _distort(self, flat: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distorted places (N, 2) of places at a depth of 1."""
        if not self.distortion.any() and not self.fisheye:
            return flat
        r2 = (flat**2).sum(axis=1)
        if self.fisheye:
            r = np.sqrt(r2)
            angle = np.arctan(r)
            k1, k2, k3, k4 = self.distortion[:4]
            a2 = angle**2
            bent = angle * (1 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
            scale = np.divide(bent, r, out=np.ones_like(r), where=r > 1e-9)
            return np.asarray(flat * scale[:, None])
        p1, p2 = self.distortion[2:4]
        x, y = flat.T
        tangential = np.stack(
            [2 * p1 * x * y + p2 * (r2 + 2 * x**2), p1 * (r2 + 2 * y**2) + 2 * p2 * x * y], axis=1
        )
        return np.asarray(flat * self._radial(r2)[:, None] + tangential)

    def _radial(self, r2: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return k1 to k3 over k4 to k6; the order is k1, k2, p1, p2, k3, k4, k5, k6."""
        k1, k2, _, _, k3, k4, k5, k6 = self.distortion[:8]
        above = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.asarray(above / (1 + r2 * (k4 + r2 * (k5 + r2 * k6))))

    def _reach(self) -> float:
        """Return the squared radius up to which the distortion grows, in focal lengths."""
        if not self.distortion.any():
            return np.inf
        r = np.arange(0.0, MOST_RADIUS, RADIUS_STEP)
        folded = np.flatnonzero(np.diff(r * self._radial(r**2)) <= 0)
        return float(r[folded[0]] ** 2) if len(folded) else np.inf
