"""Options of the sensor, its position and motion, and of the static scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt


@dataclass(frozen=True, slots=True)
class LensOptions(Options):
    """Pinhole image of a depth camera."""

    min_points: int = 500  # points from which a frame can have an image
    # Pixel of a sensor without a known lattice, in spacings of its points.
    pixel_spacings: PositiveFloat = 1.5
    min_pitch_spacings: float = 0.1  # spacings under which a pitch is chance, not a lattice's
    margin_px: int = 8  # pixels beyond the outermost points of the sample
    behind_ratio: PositiveFloat = (
        1.25  # depth over the nearest of a pixel that the sensor cannot see
    )
    behind_share: float = 0.02  # share of such points up to which the sensor is there
    behind_share_recorded: float = 0.1  # the same, for a recorded position
    filled_share: float = 0.5  # share of the pixels that a depth image fills at least
    filled_share_sought: float = 0.3  # the same, of an image from an estimated position
    torn_depth: float = 0.03  # share of its depth by which a pixel is off the next at an edge
    torn_share: float = 0.15  # share of such pairs from which an image is none
    half_view_tan: float = 1.6  # tangent of half the widest field of view of a pinhole image
    max_pixels: int = 4_000_000  # pixels of an image at most
    sampled_points: PositiveInt = 20_000  # sampled points for an image's direction and pixel size
    nearest_m: float = 0.001  # metres before the eye from which a point has a pixel
    lattice_tolerance: float = 2e-05  # difference of tangents within a column or row
    min_lattice_lines: int = 20  # minimum columns or rows of a lattice
    min_points_per_line: int = 4  # mean points of each


@dataclass(frozen=True, slots=True)
class RangeImageOptions(Options):
    """Range image of a lidar."""

    azimuth_deg: PositiveFloat = 0.4  # degrees of a cell around
    # Degrees of a cell up and down, the least that is mostly filled.
    elevations_deg: tuple[PositiveFloat, ...] = (0.4, 0.8, 1.6, 3.2)
    filled_share: float = 0.6  # share of the cells that show something
    hidden_share: float = 0.03  # share of its range by which a hidden point lies behind all others
    # Minimum points of a frame for a range image, and sampled points for their spacing.
    min_points: PositiveInt = 2000
    # Heights in metres above a frame's origin at which its sensor is searched for.
    sensor_heights_m: tuple[float, ...] = (0.0, 1.0, 1.8, 2.6)
    behind_ratio: PositiveFloat = (
        1.25  # range over the nearest in its direction that the sensor cannot see
    )
    behind_share: float = 0.02  # share of such points up to which the sensor is there
    swept_share: float = 0.07  # the same of all points: a lidar sees while it drives
    # Farthest range over nearest from which a place between is a lidar's.
    lidar_depth_ratio: float = 1.5
    same_direction_deg: float = 0.1  # degrees within which a sensor sees one surface
    min_same_direction: float = 0.005  # minimum share of points with others in their direction
    camera_reach_m: float = 15.0  # metres that depth cameras measure
    camera_share: float = 0.95  # share of the points that lie nearer
    spread_power: float = 0.5  # power of the range by which points lie farther apart if seen
    spread_neighbours: int = 3  # neighbours for the spacing
    rim_share: float = 0.02  # share of the points beyond the edges of the field of view
    stray_share: float = 0.05  # share of the nearest and farthest points, stray ones
    up_points: PositiveInt = 5000  # sampled points for the vertical axis
    blind_cells: int = 6  # cells beside the last measured direction from which nothing is seen


@dataclass(frozen=True, slots=True)
class ViewpointOptions(Options):
    """Estimation of an unrecorded sensor position."""

    part_spacings: PositiveFloat = 4.0  # spacings of the points across a part of the image
    min_mean_ray: float = 0.6  # length of the mean ray of an image at least
    min_ray_cos: float = 0.45  # cosine from the mean ray below which a ray is far aside
    # Shares of the distance at which the search starts.
    distance_shares: tuple[float, ...] = (0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.2, 1.5)
    direction_steps: tuple[float, float] = (
        0.2,
        0.003,
    )  # first and last step, in sizes of the scene
    min_points: int = 2000  # minimum points for the estimation of a position
    # Distances from the middle, in sizes of the scene.
    distance_sizes: tuple[float, ...] = (0.7, 1.0, 1.4, 2.0, 2.8)
    directions: PositiveInt = 160  # directions from the middle
    coarse_points: PositiveInt = 4000  # sampled points for the coarse search
    fine_points: PositiveInt = 30_000  # sampled points for the fine search
    followed_places: int = 4  # positions refined by the fine search
    # First and last step, and the last by all points, in sizes of the scene.
    place_steps: tuple[float, float, float] = (0.3, 0.005, 0.002)
    hidden_sizes: float = 0.05  # sizes of the scene behind another point from which one is hidden
    hidden_share: float = 0.06  # share of the points that may be hidden
    hidden_share_far: float = 0.4  # the same, far from the place
    # Share of the points that may be farther aside than an image is wide.
    stray_share: float = 0.002


@dataclass(frozen=True, slots=True)
class TintOptions(Options):
    """Colour free of shading."""

    red_weight: float = 1.7  # weight of red against green beside blue against both, nearly sqrt(3)
    dark_sum: float = 60.0  # added to the sum of the channels: the tint of black is noise
    brightness: float = 0.3  # greatest difference by brightness alone


@dataclass(frozen=True, slots=True)
class GroundOptions(Options):
    """Ground under a lidar."""

    length_share: PositiveFloat = 0.02  # share of the median distance that lengths are counted in
    cell: PositiveFloat = 6.0  # size of a cell, in such lengths
    thickness: float = 0.5  # height above the ground up to which something lies there
    kerb: float = 1.0  # height above the lowest point around up to which a cell's lowest is ground
    min_points: int = 2000  # points of a frame from which ground is looked for
    max_cells: int = 4_000_000  # cells of the grid at most
    stray_share: float = 0.05  # share of the lowest and highest points, stray ones among them


@dataclass(frozen=True, slots=True)
class VisualOdometryOptions(Options):
    """Trajectory of a depth camera: dense visual odometry."""

    signed: ClassVar[frozenset[str]] = frozenset({"start_aside_px", "start_upward_px"})

    longest_side_px: int = 200  # pixels of the finest picture's longer side at most
    shortest_side_px: int = 20  # pixels of the coarsest picture's shorter side at least
    sampled_pixels: PositiveInt = 4000  # pixels of a picture that are compared
    near_px: float = 1.0  # pixels of the coarsest picture within which no other start is tried
    tried_iterations: int = 10  # iterations of a motion that is tried
    iterations: int = 30  # iterations at each size at most
    settled_px: float = 0.02  # pixels under which a step ends the iterations
    robust_sigmas: PositiveFloat = 2.0  # deviations at which the weight of a pixel is a quarter
    min_pixels: int = 60  # pixels that have to fall into both pictures
    # Pixels of the coarsest picture by which a camera may have turned aside.
    start_aside_px: tuple[float, ...] = (-6.0, -3.0, 0.0, 3.0, 6.0)
    # Pixels by which it may have turned upward.
    start_upward_px: tuple[float, float, float] = (-3.0, 0.0, 3.0)
    starts_followed: int = 6  # starts that are refined at the next level
    moved_px: float = 0.2  # pixels of the finest picture by which the scene moves with the sensor
    left_share: float = 0.8  # share that disagreed before and still may after the motion
    band_share: float = 0.03  # share of a picture that is its border
    border_share: float = 0.3  # share of the border where a scene shows at least
    # Share of a picture by which its scene may move before a new keyframe.
    keyframe_shift: float = 0.1
    lost_agreement: float = 0.25  # minimum agreement for a pose, by the scale of the first frames


@dataclass(frozen=True, slots=True)
class ScanOdometryOptions(Options):
    """Trajectory of a lidar: planes registered point to plane."""

    cell_share: PositiveFloat = 0.02  # size of a thinning cell, as a share of the median distance
    cell_min_m: PositiveFloat = 0.5  # metres of such a cell at least, of a lidar
    plane_points: PositiveInt = 100_000  # sampled points for the search of planes
    plane_neighbours: int = 10  # neighbours that a plane is fitted to
    min_points: int = 500  # minimum points of a frame for planes
    min_planes: int = 10  # neighbourhoods likewise
    candidates_per_plane: PositiveInt = 6  # candidates for each registered place
    plane_flatness: float = 0.05  # share of the variance across a plane at most
    plane_breadth: float = 0.08  # share of the variance along its shorter side at least
    planes: PositiveInt = 1500  # planes that are registered
    # Scales of the robust weights, in cells.
    scales_cells: tuple[float, ...] = (
        8.0,
        6.0,
        4.0,
        3.0,
        2.0,
        1.5,
        1.0,
        1.0,
        0.7,
        0.7,
        0.5,
        0.5,
        0.3,
        0.3,
    )
    # Frames after the first in which a sensor's motion is tested.
    tested_frames: tuple[int, int, int] = (1, 4, 12)
    examined_frames: int = 12  # frames, across a recording, that have to show its sensor at rest
    moved_cells: float = 0.25  # cells by which the scene is displaced, at the median, if it moved
    rest_pose: float = 0.0001  # metres and radians between the recorded poses of a sensor at rest
    on_plane_cells: float = 0.2  # cells off its plane up to which a point lies on it
    # Share of the planes in place above which the sensor rests, and no other start is tried.
    rest_share: float = 0.95
    agreed_share: float = 0.5  # share that has to be in place after a motion, or a jump
    left_share: float = 0.75  # maximum share of displaced planes that remain displaced
    restart_drop: float = 0.05  # tolerated fall of the share in place since the last frame
    shifts: int = 2  # shifts that are tried
    shift_cells: float = 1.0  # cells from the found motion at which a shift is another start
    shift_pixel_cells: PositiveFloat = 3.0  # size of a pixel, in thinning cells
    shift_side_px: int = 256  # pixels of a picture along each side
    shift_steep_px: float = 1.0  # pixels between the highest and lowest point of upright surface
    shift_max_px: int = 64  # pixels of the longest shift
    shift_whitening: float = 0.5  # whitening of the correlation: 0 none, 1 phases alone
    shift_same_px: int = 2  # pixels around a shift that are no other shift
    max_skew: float = 0.1  # determinant off 1 from which a matrix is no pose


@dataclass(frozen=True, slots=True)
class SwayOptions(Options):
    """A camera that only sways."""

    max_parallax: float = 0.03  # tangent of the angle by which near and far move against each other
    near_percentile: int = 10  # percentile of the depths that are near; as many are far
    max_extent: float = 2.0  # sizes of the sensor's picture up to which all that it sees extends
    margin_share: float = 0.1  # share of a picture added on each side for the frames between


@dataclass(frozen=True, slots=True)
class BackgroundOptions(Options):
    """The static scene of a depth camera or a lidar."""

    # Share of the continued scene's depth from which a depth is the scene's.
    same_depth_share: float = 0.93
    seldom_share: float = 0.25  # share of the frames that must show the scene
    often_share: float = 0.5  # share of the frames that must show surface off the continued scene
    min_showing_frames: float = 2.0  # minimum number of these frames
    # Noise deviations from which a point may belong to an object touching the background.  Without:
    # a card on a table -.083 (tests/tracking/guards).
    faint_sigmas: float = 0.5
    # Noise deviations by which an object must have gone to leave a pixel.
    departed_sigmas: float = 2.0
    # Share of an object's points from which static points are no foot of it.
    foot_share: float = 0.1
    rim_px: int = 3  # pixels beside labelled ones that are not learnt as background
    # Share of an object's length behind and beside it within which surface may be a side of it.
    side_share: float = 0.15
    # Share of an object's visible pixels that must be where they were, for it to rest.
    stayed_share: float = 0.5
    # Share of its depth at which the continued scene behind an object begins.
    hidden_share: float = 0.985
    learn_rate: float = 0.2  # weight of a seen depth in the running mean
    kept_scans: int = 3  # scans that are kept: the first, which a person labelled, and later ones
    rim_reaches: float = 2.0  # reaches beside labelled points that are not taken for background
    min_picture_share: float = 0.1  # minimum share of a picture for the noise
    # Share of the frames that may show no scene, such as behind a hand.
    covered_share: float = 0.125
    # Without: boxes -.007, a crowd -.075.
    survey_frames: int = 16  # frames for the scene hidden by large objects
    near_sigmas: float = 3.0  # noise deviations within which a depth is the same depth
    fill_cell_px: PositiveInt = 4  # pixels of a cell in which the hidden scene is continued
    empty_cells: int = 4  # unmeasured cells around one from which no scene is there
    far_m: PositiveFloat = 1000.0  # metres at which the endlessly far scene is drawn
    # Share of its depth within which a surface continues to the next pixel.
    surface_jump_share: float = 0.01
    min_known_beside: int = 3  # known pixels beside one in doubt that decide it


@dataclass(frozen=True, slots=True)
class DepthNoiseOptions(Options):
    """Noise of depth, measured between two frames."""

    default_m: float = 0.004  # metres of noise of a sensor with unknown noise
    default_per_m2: float = 0.002  # metres more for each square metre of depth
    same_depth_m: float = 0.0001  # metres up to which two depths are the same
    stepped_share: float = 0.2  # share of equal depths from which depth comes in steps
    step_sigma: float = 0.4  # standard deviation of a depth between two steps, in steps
    min_pixels: int = 100  # minimum pixels for the noise
    depth_bins: int = 10  # bins of depth, each with its own noise
    floor_m: float = 0.0005  # metres of noise that any depth camera has


@dataclass(frozen=True, slots=True)
class MappingOptions(Options):
    """The static scene of a carried camera."""

    beside_m: float = 0.4  # metres from an object's last place in which new surface may be its own
    min_views: int = 2  # frames that have to show a surface element
    seen_through_share: float = 0.1  # frames that may see through it, for each that shows it
    shown_share: float = 0.25  # share of the frames with it in the picture that have to show it
    # Share of the longest object's length for the rest of another behind it.
    body_share: float = 0.5
    sampled_points: PositiveInt = 2000  # sampled points for the distance from an object
    rim_px: int = 2  # pixels about an object that are its outline
    outline_share: float = 0.03  # share of its distance by which a surface changes at an outline
    steep_share: float = 0.05  # share of its distance by which an element may differ within a pixel
    closest_m: float = 0.05  # metres before the sensor from which an element is drawn
    filled_beside: int = 3  # drawn pixels beside an empty one from which it is filled
