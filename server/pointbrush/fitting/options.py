"""Numbers of the fit of boxes, each with its unit."""

from __future__ import annotations

from dataclasses import dataclass, fields

from pointbrush.errors import BadInputError


@dataclass(frozen=True, slots=True)
class FitOptions:
    """Settings of a fit; metres and degrees."""

    least_points: int = 4
    """Points of a label that a frame needs at least to be fitted."""
    stray_gap: float = 0.4
    """Metres between neighbours that part a label's points into pieces …"""
    stray_gap_angle: float = 0.02
    """… and what a metre of distance from the sensor adds to it."""
    stray_share: float = 0.06
    """Share of a label's points up to which a piece apart from the rest is left out."""
    clearance: float = 0.2
    """Metres above the ground below which points say nothing about sides."""
    edge_depth: float = 0.15
    """Metres behind the outermost points within which points belong to a side."""
    edge_quantile: float = 0.85
    """Quantile of these points, outward, at which the side is."""
    person_margin: float = 0.04
    """Metres from the outermost points of a person or a two-wheeler to the sides: beams miss the
    ends of limbs and handlebars."""
    band: tuple[float, float] = (0.22, 0.5)
    """Shares of the height between which a body is solid: rays that pass there say it is free."""
    inner: float = 0.6
    """Share of a side, at its middle, beside which rays say that it ends."""
    outer: float = 0.9
    """The same share where a box reaches past its round corners, …"""
    corner: float = 0.3
    """… so many metres from its end."""
    bin_size: float = 0.05
    """Metres; steps in which free space beside a side is looked for."""
    ray_cost: float = 0.5
    """Nats that a ray through a box costs: some go through windows and under the body."""
    rays_spare: int = 2
    """Rays through one step that count for nothing: they may be stray."""
    rays_most: int = 30
    """Rays through one step that count, at most."""
    frames_most: float = 4.0
    """Frames whose rays count in full, at most: those of more are much alike."""
    most_rays: int = 6000
    """Rays of a frame that are looked at, at most."""
    ground_cell: float = 0.5
    """Metres; width of the cells whose lowest points are the ground's."""
    ground_reach: float = 4.0
    """Metres round an object within which its ground is looked for."""
    yaw_step: float = 1.0
    """Degrees between the directions that are tried first."""
    yaw_fine: float = 0.1
    """Degrees between those tried round the best."""
    yaw_choices: int = 4
    """Directions of the outline among which the likeliest sizes choose …"""
    yaw_apart: float = 10.0
    """… so many degrees apart at least …"""
    yaw_nats: float = 30.0
    """… and what points close to the sides count there, nats for all right at them."""
    yaw_cell: float = 0.06
    """Metres; cells to whose means points are thinned for the search over yaw."""
    yaw_floor: float = 0.05
    """Metres from a side below which points count as being on it."""
    moved: float = 0.5
    """Metres that an object must have gone to count as moving …"""
    sharper: float = 0.95
    """… and the ratio to which this must shrink the cells that its points fill."""
    sharp_cell: float = 0.2
    """Metres; width of these cells."""
    headed: float = 1.0
    """Metres that an object must have moved for its front to be known."""
    acceleration: float = 4.0
    """Metres a second squared; standard deviation of a path's bend."""
    side_noise: float = 0.06
    """Metres; standard deviation of a side that was seen."""
    lshape_noise: float = 3.0
    """Degrees; standard deviation of a direction by the sides of one frame …"""
    lshape_points: int = 60
    """… that has so many points; more say more, down to a third of it."""
    path_seconds: float = 0.4
    """Time over which a path tells a direction …"""
    path_lag: float = 0.3
    """… and by which it tells that of what turns late or early, seconds."""
    path_noise: float = 0.18
    """Metres; standard deviation, across, of how far a path went in that time: its places move
    with the sides that are seen."""
    swerve: float = 80.0
    """Degrees a second squared; what the rate of a vehicle's turn is likely to change by."""
    person_swerve: float = 1000.0
    """The same of somebody on foot."""
    walking: float = 0.3
    """Metres a second from which on somebody faces the way they go."""
    rounds: int = 3
    """Times that sides, path and direction of what moves are found in turn."""

    def check(self) -> None:
        """Check the numbers.  Raises BadInputError."""
        for each in fields(self):
            value = getattr(self, each.name)
            if min(value if isinstance(value, tuple) else (value,)) <= 0:
                raise BadInputError(f"{each.name}: expected above 0, got {value}")
        if not self.band[0] < self.band[1] <= 1:
            raise BadInputError(f"band: expected two ascending shares, got {self.band}")
