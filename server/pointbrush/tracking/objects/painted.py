"""What a person painted: facts of the first sight that hold however little is seen later."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.interface import F64, I64
from pointbrush.tracking.objects.shape import across_way, away_from, cut_off_by_edge, uneven
from pointbrush.tracking.sensor.view import View


@dataclass(frozen=True)
class Painted:
    """How a thing was painted.

    ``flat`` lying on the ground; ``sheet`` flat in itself, as a door is; ``broad`` as part of
    somebody is; ``cut`` off by the edge of the picture; ``grounded`` with the ground under it;
    ``with_flying`` with the flying pixels at its outline.
    """

    flat: bool
    sheet: bool
    broad: bool
    cut: bool
    grounded: bool = False
    with_flying: bool = False

    @staticmethod
    def of(view: View, indices: I64, xyz: F64, radius: float) -> Painted:
        """As the points ``indices`` (M,) at ``xyz`` (M, 3) show it, ``radius`` metres in size."""
        options = view.options.track
        return Painted(
            flat=float(view.low[indices].mean()) > options.flat_share,
            sheet=uneven(xyz, options=options) < options.sheet_radii * radius,
            broad=across_way(xyz) > options.broad_m and away_from(view, xyz) > options.afar_m,
            cut=cut_off_by_edge(view, indices),
        )
