"""Options of a run, of the state of a track, and of tracks that meet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt


@dataclass(frozen=True, slots=True)
class CompanionOptions(Options):
    """Companion labels: number, size, and distance within which they are tracked."""

    most: int = 12
    """Maximum number of companions, the nearest ones, to limit the cost among many objects."""
    larger: float = 2.0
    """Maximum ratio of size to the largest requested label, to exclude floors and walls."""
    near_radii: float = 0.25
    """Radii around a label's expected position, added to the two below, within which companions of
    an earlier run are tracked; farther ones keep their stored points."""
    near_units: float = 4.0
    """Units of tolerance, likewise."""
    near_steps: float = 0.5
    """Times the label's speed, for each frame since it was seen, likewise."""
    sampled_points: PositiveInt = 60
    """Sampled points of a label for this test."""


@dataclass(frozen=True, slots=True)
class JumpOptions(Options):
    """Jumps of a sensor at rest: detection and registration."""

    stride_frames: int = 8
    """Frames between two compared frames; if these differ, the frames between are compared."""
    sampled_points: PositiveInt = 500
    """Sampled points of a frame that are searched for in another."""
    near_share: float = 0.03
    """Distance within which a point is found again, in median distances from the middle; at
    least ``near_spacings``."""
    near_spacings: float = 3.0
    """Spacings of the other frame's points, likewise."""
    stays_share: float = 0.85
    """Share of the points that are found again while the sensor rests."""
    shifts: int = 4
    """Number of shifts from which frames are registered."""
    pixel_cells: PositiveFloat = 2.0
    """Size of a pixel of the correlation, in cells that the frames are thinned to."""
    side_pixels: int = 128
    """Pixels of the correlation along each side."""
    least_cells: float = 2.0
    """Minimum displacement of the scene by a jump, in cells."""
    rest_share: float = 0.25
    """Share of that allowed between frames before and frames after the jump."""
    patience: int = 2
    """Number of displacements without a jump after which the sensor counts as moving."""
    sure: float = 0.8
    """Maximum confidence in the first frame after a jump."""
    reach_spacings: float = 2.5
    """Spacings within which points are an object's there; points that stay behind are lost."""


@dataclass(frozen=True, slots=True)
class StrainOptions(Options):
    """Whether an object bends."""

    signed: ClassVar[frozenset[str]] = frozenset({"outline_offsets_px"})

    min_known_points: int = 100  # known points that have to be in sight
    min_off_share: float = 0.005  # minimum share of them off their place for a test of strain
    stiff_frames: PositiveInt = 4  # frames between two tests of a stiff object
    hint_share: float = 0.25  # share of soft strain from which all frames are tested
    loose_cost: float = 0.15  # cost of a fit from which all frames of a dense object are tested
    max_frame_ratio: float = 1.5  # maximum ratio of a frame's strain to the soft strain
    bent_points: PositiveInt = 600  # maximum deformed points of a test
    target_points: PositiveInt = 6000  # maximum target points of a test
    off_units: float = 1.5  # units from a measurement at which a model point is off its place
    on_units: float = 1.0  # units at which it is on it
    far_units: float = 3.0  # units within which measurements are searched for
    unexplained_units: float = 2.0  # units from the model from which it does not explain a point
    # Pixels, each way, from which an outline is beside a point.  Without: boxes of 40 frames, seed
    # 802, -.007, one object lost.
    outline_offsets_px: tuple[int, int, int] = (-2, 0, 2)
    share_rate: float = 0.15  # weight of a frame in the running mean of the bending share
    strain_rate: float = 0.2  # weight of a frame in the running mean of strain


@dataclass(frozen=True, slots=True)
class SurfaceOptions(Options):
    """Surface model of a track."""

    carve_views: int = 10  # earlier views kept of an object
    carve_units: float = 3.0  # units by which a measurement lies behind a place looked through
    # Without: 3 pins -.012, boxes -.001.
    carve_min_views: int = 2  # views that have to agree: one pose may be wrong
    carve_margin_px: int = 8  # pixels around the object that are kept
    carve_turn_deg: float = 12.0  # degrees between two views that are kept
    max_points: PositiveInt = 2500  # points of a model
    max_points_bent: PositiveInt = (
        1000  # points of a model that is made anew in each frame, since it bends
    )
    sure_hits: float = 12.0  # hits from which a point may have new neighbours
    radius_share: float = 0.98  # share of the points within the radius
    hit_spacings: float = 1.2  # spacings up to which a measured point hits a known one
    new_spacings: float = 0.9  # spacings from which a measured point is new surface
    min_points: int = 10  # points that a model keeps at least
    max_counted_hits: int = 4  # hits that count against misses
    cell_spacings: PositiveFloat = 0.8  # spacings across a cell that keeps one point
    coarser_factor: float = 1.05  # how much coarser a full model becomes
    facing_cos: float = 0.25  # cosine between directions from which a point was and would be seen


@dataclass(frozen=True, slots=True)
class AppearanceOptions(Options):
    """Colour histograms."""

    signed: ClassVar[frozenset[str]] = frozenset({"strange_share"})
    # Without colours of its own: boxes -.084.
    own_colour_ratio: float = 10.0  # ratio of shares from which a colour is the track's own
    coarse_bins: PositiveInt = 3  # bins, each way, of the cells of a histogram of few colours
    alike_share: float = 0.7  # share of colours that it showed from which a surface may be its
    common_share: float = 0.02  # share of colours from which they are common
    # Mean log ratio by which colours may be rarer than its own and still like them.
    rarer_log: float = 2.0
    absent_share: PositiveFloat = 0.002  # share of colours that are nowhere among the painted ones
    # Without colours never shown: 6 pins -.008.
    strange_share: float = 0.002  # share of hues, however bright, up to which they are strange


@dataclass(frozen=True, slots=True)
class ObjectOptions(Options):
    """Kind of object that a label is, and its tolerance."""

    # Confidence of a label restarted from its part that reappeared from behind another.
    emerged_confidence: float = 0.3
    # Units within which a point is at a static point, without a depth image.
    static_units: float = 1.5
    default_unit_m: float = 0.02  # metres of a unit while nothing is tracked
    sheet_radii: float = 0.016  # radii from its plane that hold half of a flat object
    broad_m: float = 0.06  # metres of deviation across from which a label is part of a person
    afar_m: float = 1.5  # minimum metres from the sensor for that
    flat_share: float = 0.6  # share of its points on the ground from which it lies there
    ring_neighbours: int = 24  # neighbours among which the next ring of a lidar is looked for
    ring_cos: float = 0.5  # cosine of a way aside
    ring_share: float = 0.3  # share of the way between rings that is a unit
    # Least share of an object's points that one of several sensors has, for its spacing to count.
    sensor_share: float = 0.1
    edge_px: int = 2  # pixels from the edge of the picture
    edge_share: float = 0.15  # share of the painted points at the edge from which it is cut
    contact_share: float = 0.3  # share of its width along the edge that touches it likewise
    cut_m: float = 0.2  # minimum metres of radius for that contact
    entering_frames: int = 4  # frames in which a smaller one is judged again
    sampled_points: PositiveInt = 400  # sampled points for distances to neighbours
    lone_spacing_m: float = 0.02  # metres between points if they are too few
    min_spacing_m: PositiveFloat = 0.0001  # metres between points at least, where all are one point
    black_share: float = 0.1  # share of black points from which colours are incomplete
    min_colour_noise: PositiveFloat = 0.03  # least colour noise
    bent_share: float = 0.2  # unexplained share from which an object bends
    bent_share_large: float = 0.05  # the same, of a large one
    tall_m: float = 0.4  # metres of radius from which an object is large as people are
    tall_units: float = 12.0  # units of radius likewise, however coarsely it is seen
    part_m: float = 0.25  # metres of radius from which a broad label is part of a person
    part_units: float = 5.0  # units of radius that such a part has at least
    # Share of known surface found by bending alone from which it is soft.
    soft_strain: float = 0.006
    hardly_share: float = 0.2  # share of its size under which an object is mostly occluded
    min_unit_spacings: float = 0.5  # share of the model's spacing that a unit is at least
    max_approach: PositiveFloat = 2.0  # times as near or far as an object comes in a frame at most
    colour_units: float = 0.5  # units that a usual colour difference between neighbours counts for
    # Number of points from which an object is subsampled.
    dense_points: PositiveInt = 3000


@dataclass(frozen=True, slots=True)
class IdentityOptions(Options):
    """Two tracks that met."""

    meeting_units: float = 6.0  # units between two objects within which they may be exchanged
    prediction_units: float = 2.0  # units by which a prediction is off at the best
    # Ratio of squared distances as found to exchanged, from which they may be exchanged.
    uneven_ratio: float = 0.35
    even_ratio: float = 0.7  # the same, from which it is as likely as not
    unsure_confidence: float = 0.85  # maximum confidence above `uneven_ratio`
    doubted_confidence: float = 0.45  # maximum confidence above `even_ratio`
    alike_radius_ratio: float = 1.5  # ratio of radii up to which two look alike
    compared_frames: int = 4  # frames before and after that are compared
    smooth_ratio: float = 0.25  # unevenness as found over swapped, up to which they are right
    # Share of the distance between two objects within which their identities are clear.
    clear_share: float = 0.3


@dataclass(frozen=True, slots=True)
class SmoothingOptions(Options):
    """Fixed-lag smoothing."""

    lag_frames: int = 12  # maximum frames for which a result is held back
    sure: float = 0.5  # confidence from which a detection is certain
