"""Numbers of the fit of boxes, each with its unit."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FitOptions:
    """Settings of a fit; metres and degrees."""

    least_points: int = 4
    """Minimum number of a label's points for the fit of a frame."""
    stray_gap: float = 0.4
    """Metres between neighbours that separate a label's points into components …"""
    stray_gap_angle: float = 0.02
    """… plus this many metres per metre of distance from the sensor."""
    stray_share: float = 0.06
    """Share of a label's points up to which a separate component is left out."""
    clearance: float = 0.2
    """Metres above the ground below which points are ignored for sides."""
    edge_depth: float = 0.15
    """Metres behind the outermost points within which points belong to a side."""
    edge_quantile: float = 0.85
    """Quantile of these points, outward, at the side."""
    person_margin: float = 0.04
    """Metres from the outermost points of a person or a two-wheeler to the sides, because beams
    miss the ends of limbs and handlebars."""
    margin: float = 0.03
    """The same of a vehicle, because its body is round and its mirrors are thin."""
    band: tuple[float, float] = (0.22, 0.5)
    """Range of shares of the height in which a body is solid, so that passing rays mean free
    space."""
    inner: float = 0.6
    """Share of a side, at its middle, beside which passing rays limit the box."""
    outer: float = 0.9
    """The same share beyond the round corners of a box, …"""
    corner: float = 0.3
    """… this many metres from its end."""
    bin_size: float = 0.05
    """Metres; steps of the search for free space beside a side."""
    ray_cost: float = 0.5
    """Cost, in nats, of a ray through a box: some pass through windows and below the body."""
    rays_spare: int = 2
    """Number of ignored rays through one step: they may be outliers."""
    rays_most: int = 30
    """Maximum number of counted rays through one step."""
    frames_most: float = 4.0
    """Maximum number of frames with fully counted rays: rays of further frames are similar."""
    most_rays: int = 6000
    """Maximum number of rays of a frame."""
    lowest_sensor: float = 0.5
    """Metres above the ground; a lower position is the origin of a vehicle and not a sensor."""
    roof: float = 1.8
    """Metres above the ground of the sensor on the roof of such a vehicle."""
    ground_cell: float = 0.5
    """Metres; width of the cells for the lowest points, on the ground."""
    ground_reach: float = 4.0
    """Metres around an object for the search of its ground."""
    ground_slope: float = 0.03
    """Standard deviation of the slope of the ground, as a share …"""
    ground_noise: float = 0.05
    """… and, in metres, of the lowest points of its cells."""
    yaw_step: float = 1.0
    """Degrees between the first candidate yaws."""
    yaw_fine: float = 0.1
    """Degrees between candidate yaws around the best one."""
    yaw_choices: int = 4
    """Number of yaws by the outline, among which the likelihood of sizes decides …"""
    yaw_apart: float = 10.0
    """… at least this many degrees apart …"""
    yaw_nats: float = 30.0
    """… and the weight of closeness to the sides there, in nats if all points are on them."""
    yaw_cell: float = 0.06
    """Metres; cells for thinning points to means in the search over yaw."""
    yaw_floor: float = 0.05
    """Metres from a side below which points count as being on it."""
    shoulders: tuple[float, float] = (0.68, 0.86)
    """Range of shares of a person's height at the shoulders, which are wider than deep …"""
    shoulder_points: int = 12
    """… with a minimum number of points …"""
    shoulder_ratio: float = 2.0
    """… and a minimum ratio of their standard deviations across and along."""
    moved: float = 0.5
    """Minimum path of a moving object in metres …"""
    sharper: float = 0.95
    """… and maximum ratio of the filled cells after compensation of the motion."""
    sharp_cell: float = 0.2
    """Metres; width of these cells."""
    headed: float = 1.0
    """Minimum motion of an object, in metres, for a known front."""
    agreeing: int = 3
    """Minimum number of frames for choosing the yaw of each frame by their common size."""
    agreed_spread: float = 0.7
    """Standard deviation of this size, as a share of that of the class."""
    start_noise: float = 0.3
    """Metres; standard deviation of a position that is found in a single frame."""
    acceleration: float = 4.0
    """Metres per second squared; standard deviation of a path's acceleration."""
    side_noise: float = 0.06
    """Metres; standard deviation of a visible side."""
    lshape_noise: float = 3.0
    """Degrees; standard deviation of a yaw by the sides of one frame …"""
    lshape_points: int = 60
    """… with this many points; it decreases with more points, down to a third."""
    path_seconds: float = 0.4
    """Time, in seconds, over which a path determines a yaw …"""
    path_lag: float = 0.3
    """… and error in time of the yaw of a turning object, in seconds."""
    path_noise: float = 0.18
    """Metres; standard deviation, across, of the path in that time: its positions shift with the
    visible sides."""
    path_angles: tuple[float, float] = (1.0, 25.0)
    """Degrees; least and greatest standard deviation of the direction of a path."""
    driving: float = 1.0
    """Metres per second below which a vehicle's path hardly constrains its yaw."""
    outline_within: float = 12.0
    """Maximum angle, in degrees, between the direction of the path and the outline's."""
    axle: float = 0.28
    """Distance of the fixed axle behind the middle, as a share of a vehicle's length."""
    steer_most: float = 0.5
    """Maximum tangent of the angle between a vehicle's axis and the path of its middle."""
    swerve: float = 80.0
    """Degrees per second squared; standard deviation of the change of a vehicle's yaw rate."""
    person_swerve: float = 1000.0
    """The same of a pedestrian."""
    person_noise: float = 17.0
    """Degrees; standard deviation of the direction of a pedestrian's path."""
    walking: float = 0.3
    """Metres per second from which a person faces the direction of motion."""
    rounds: int = 3
    """Number of alternations over sides, path and yaw of a moving object."""
