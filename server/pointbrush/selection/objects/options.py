"""Tunable numbers of object selection, each with its unit, in one place."""

from __future__ import annotations

from dataclasses import dataclass, field

from pointbrush.selection.candidate import MOST_LEVELS
from pointbrush.sensor_kind import SensorKind


@dataclass(frozen=True, slots=True)
class CellOptions:
    """Sizes of the cubes that stand for the points in them."""

    size: float = 0.02
    """Metres; tried first for rooms and depth cameras."""
    lidar_size: float = 0.10
    """Metres; tried first for lidar."""
    fewest: int = 60_000
    """Cells; with fewer a smaller size is tried, as far as the points are that close."""
    lidar_fewest: int = 30_000
    """The same for lidar."""
    most: int = 160_000
    """Cells; with more a larger size is taken."""
    points_per_cell: float = 1.4
    """Points; cells are not made so small that they hold fewer on average."""


@dataclass(frozen=True, slots=True)
class GroundOptions:
    """Ground under a lidar."""

    column: float = 1.0
    """Metres; edge of a column of the plan."""
    most_columns: int = 1_000_000
    """Columns; wider frames get larger ones."""
    fewest_points: int = 5
    """Cells in a column that has a ground height of its own."""
    decile: float = 0.1
    """Share of a column's cells that lie below its ground height."""
    ghost_depth: float = 0.6
    """Metres under its surroundings at which a column is a reflection, not ground."""
    slope: float = 0.2
    """Metres up per metre along; ground is not steeper."""
    sweeps: int = 30
    """Passes over the columns while the slope is made to hold."""
    clearance: float = 0.2
    """Metres over the ground above which a cell is no part of it."""


@dataclass(frozen=True, slots=True)
class GraphOptions:
    """Neighbours of cells, and the edges of the first graph."""

    neighbours: int = 12
    """Cells round a cell that give its normal."""
    linked: int = 7
    """Of these, cells that it may have edges to (rooms and depth cameras)."""
    reach_spacings: float = 2.5
    """Times the distance of the sixth neighbour; edges are shorter."""
    reach_cells: float = 6.0
    """Times the cell size; edges are shorter."""
    lidar_reach: float = 0.3
    """Metres; edges of lidar are shorter than this and a share of the range."""
    lidar_reach_per_metre: float = 0.012
    """Metres per metre of range."""


@dataclass(frozen=True, slots=True)
class PieceOptions:
    """The first, small pieces (Felzenszwalb and Huttenlocher, IJCV 2004)."""

    scale: float = 0.03
    """Weight times cells; larger makes larger pieces."""
    lidar_scale: float = 0.2
    """The same for lidar."""
    colour: float = 0.002
    """Weight of one unit of CIE Lab distance."""
    fewest: int = 8
    """Cells of the smallest piece, as far as it has neighbours."""
    lidar_fewest: int = 3
    """The same for lidar."""
    ground_step: float = 10.0
    """Weight added between ground and what is above it (lidar)."""


@dataclass(frozen=True, slots=True)
class BridgeOptions:
    """Links between detached components, for the merge tree alone."""

    links: int = 4
    """Links from a component to others, the shortest."""
    reach: float = 0.3
    """Metres, depth camera."""
    lidar_reach: float = 2.5
    """Metres, lidar."""


@dataclass(frozen=True, slots=True)
class PlaneOptions:
    """Coplanar pieces that touch."""

    least_seed: float = 0.002
    """Square metres of the smallest piece from which a plane is sought."""
    least_area: float = 0.05
    """Square metres of the smallest plane."""
    off: float = 0.02
    """Metres by which a piece of the same colour may lie off the pieces of the plane about it."""
    off_cells: float = 1.5
    """Times the cell size; the same, where that is more."""
    strict_off: float = 0.012
    """As ``off``, for planes that leave out flat pictures and doors; at least the cell size."""
    gap: float = 1.0
    """Metres between pieces of one plane that continues beyond furniture."""
    gap_area: float = 0.03
    """Square metres of the smallest piece beyond a gap."""
    rough: float = 1.5
    """Times the above, by which its cells may be off their own mean height (root mean square)."""
    along: float = 0.6
    """Share of its normals that points along the plane's normal, at least."""
    near: float = 0.5
    """Metres about a piece within which the plane's pieces count most."""
    colour: float = 14.0
    """Lab units by which the colour of a level piece may differ from theirs."""
    colour_share: float = 0.95
    """Share of the step to the plane that colours make up at most: tiles are one floor."""
    lightness: float = 0.3
    """Weight of the lightness in that difference: lamps and shadows change it."""
    rounds: int = 8
    """Times that a plane is fitted to the pieces found on it."""


@dataclass(frozen=True, slots=True)
class LadderOptions:
    """Levels that are offered for a click."""

    levels: int = MOST_LEVELS
    """Candidates shown at most."""
    closest: float = 0.75
    """Size ratio above which two candidates are as good as the same."""
    closest_after: float = 0.93
    """The same once something is taken: corrections are small."""
    times: int = 40
    """Unions over merge times that are looked at."""
    growing: frozenset[SensorKind] = frozenset({"room", "camera"})
    """Sensors for which regions are grown besides; their value model has seen such regions."""
    grown: int = 120
    """Pieces that a region is grown by, at most."""
    grown_kept: int = 24
    """Regions on the way that are looked at."""
    spill: float = 0.1
    """Share of a plane that the level shown first may reach beyond it and still nest with it."""
    closest_flat: float = 0.95
    """Overlap from which on a plane is as good as a level that is offered."""
    flat_area: float = 1.4
    """Square metres of a plane that is as likely the clicked surface as not."""
    flat_slope: float = 1.2
    """Log odds by which this rises with the log of the area."""
    flat_most: float = 2.0
    """Log odds at most."""
    keep: float = 0.02
    """Score by which another candidate must be better than what was taken, to be shown first."""
    sure_far: float = 1.2
    """Times the standard deviation of a lidar selection along its longest axis: if contradicting
    clicks lie nearer to its border, it is likely right."""
    sure_keep: float = 0.12
    """As ``keep``, for such a selection: once corrected, it is better than its score."""
    room_keep: float = 0.08
    """The same in scanned rooms, where scores are less sure."""
    camera_keep: float = 0.06
    """The same before depth cameras."""
    camera_odds: float = 2.2
    """Log odds of the overlap of the level shown first, at a score of 0.5, before depth cameras."""
    camera_slope: float = 0.2
    """Log odds by which they rise with the log odds of the score."""
    lidar_odds: float = 0.24
    """Log odds by which scores rise with the log of the cells of the level shown first (lidar)."""
    lidar_cells: float = 100.0
    """Cells of that level at which the scores are as the model gives them."""


@dataclass(frozen=True, slots=True)
class ClickOptions:
    """Places that clicks are taken at, and the least that one changes of what is taken."""

    real_cells: int = 6
    """Cells of the smallest piece that a click lies on, if there is one within reach."""
    real_reach: float = 6.0
    """Times the cell size by which such a piece may be farther than the nearest cell."""
    lone_cells: int = 3
    """Cells of the smallest piece of a lidar frame that is more than lone returns."""
    lone_angle: float = 8.0
    """Degrees, seen from the lidar, within which a click on a lone return looks for a piece."""

    least_cells: float = 1.5
    """Times the cell size; the smallest radius of a patch."""
    sure_added_share: float = 0.5
    """Share of the distance to the selection within which a wanted click adds cells to a
    lidar selection that is likely right; otherwise the whole distance."""
    sure_patch: float = 0.03
    """Share of the cells of such a selection that one click adds or removes at most."""
    removed_share: float = 0.5
    """Share of the way to what is not taken within which an unwanted click takes away."""
    whole_share: float = 0.5
    """Share of a piece from which on what a click adds is the whole piece."""


@dataclass(frozen=True, slots=True)
class ObjectOptions:
    """All of them."""

    cells: CellOptions = field(default_factory=CellOptions)
    ground: GroundOptions = field(default_factory=GroundOptions)
    graph: GraphOptions = field(default_factory=GraphOptions)
    pieces: PieceOptions = field(default_factory=PieceOptions)
    bridges: BridgeOptions = field(default_factory=BridgeOptions)
    clicks: ClickOptions = field(default_factory=ClickOptions)
    planes: PlaneOptions = field(default_factory=PlaneOptions)
    ladder: LadderOptions = field(default_factory=LadderOptions)
