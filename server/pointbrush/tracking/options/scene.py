"""Options of the scene at rest."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.options.base import Options


@dataclass(frozen=True, slots=True)
class BackgroundOptions(Options):
    """The scene at rest before a depth camera or a lidar."""

    # Share of the continued scene's depth from which a depth is the scene's.
    same_depth_share: float = 0.93
    seldom_share: float = 0.25  # share of the frames that must show the scene
    often_share: float = 0.5  # share of the frames that must show what lies off the continued scene
    min_showing_frames: float = 2.0  # fewest frames that do: one alone may show anything
    # Noise deviations from which a point may be of what touches the background.
    faint_sigmas: float = 0.5
    # Noise deviations by which an object must have gone to leave a pixel.
    departed_sigmas: float = 2.0
    # Share of an object's points from which what stands there is no foot of it.
    foot_share: float = 0.1
    rim_px: int = 3  # pixels beside labelled ones that are not learnt as background
    side_share: float = 0.15  # share of an object's length behind which nothing is a side of it
    # Share of an object's visible pixels that must be where they were, for it to rest.
    stayed_share: float = 0.5
    # Share of its depth at which the continued scene behind an object begins.
    hidden_share: float = 0.985
    learn_rate: float = 0.2  # share of the way that a known depth goes to what is seen
    kept_scans: int = 3  # scans that are kept: the first, which a person labelled, and later ones
    rim_reaches: float = 2.0  # reaches beside labelled points that are not taken for background
    calm_frames: int = 4  # frames from which the noise of each pixel is measured
    min_picture_share: float = 0.1  # share of a picture that tells the noise alone
    # Share of the frames that may show nothing of the scene, as behind a hand.
    covered_share: float = 0.125
    survey_frames: int = 16  # frames that are looked through for what large objects hide
    near_sigmas: float = 3.0  # noise deviations within which a depth is the same depth
    fill_cell_px: int = 4  # pixels of a cell in which the hidden scene is continued
    empty_cells: int = 4  # unmeasured cells around one from which no scene is there
    block_px: int = 16  # pixels along a block that shares one noise deviation
    block_min_px: int = 64  # measured pixels of a block that tell its deviation
    far_m: float = 1000.0  # metres at which the endlessly far scene is drawn
    usual_over_calmest: float = 1.15  # usual deviation over that of the calmest pair of frames
    # Share of its depth within which a surface goes on to the next pixel.
    surface_jump_share: float = 0.01
    min_known_beside: int = 3  # known pixels beside one in doubt that decide it
    min_block_sigma: float = 0.6  # least deviation of a block over that expected at its depth
    max_block_sigma: float = 2.5  # greatest deviation of a block over that expected at its depth


@dataclass(frozen=True, slots=True)
class DepthNoiseOptions(Options):
    """Noise of depth, measured between two frames."""

    default_m: float = 0.004  # metres of noise of a sensor that does not tell it
    default_per_m2: float = 0.002  # metres more for each square metre of depth
    same_depth_m: float = 0.0001  # metres up to which two depths are the same
    stepped_share: float = 0.2  # share of equal depths from which depth comes in steps
    step_sigma: float = 0.4  # standard deviation of a depth between two steps, in steps
    min_pixels: int = 100  # pixels that tell the noise
    depth_bins: int = 10  # parts by depth, each of which tells the noise for itself
    floor_m: float = 0.0005  # metres of noise that any depth camera has


@dataclass(frozen=True, slots=True)
class MappingOptions(Options):
    """The scene at rest before a camera that is carried."""

    beside_m: float = 0.4  # metres from an object's last place within which new surface may be its
    min_views: int = 2  # frames that have to show a surface element
    seen_through_share: float = 0.1  # frames that may see through it, for each that shows it
    shown_share: float = 0.25  # share of the frames in whose picture it lies that have to show it
    # Share of an object's length behind and beside it for another side of it.
    side_share: float = 0.15
    # Share of the longest object's length for the rest of another behind it.
    body_share: float = 0.5
    sampled_points: int = 2000  # points of an object of which its distance is asked
    rim_px: int = 2  # pixels about an object that are its outline
    outline_share: float = 0.03  # share of its distance by which a surface changes at an outline
    steep_share: float = 0.05  # share of its distance by which an element may differ within a pixel
    closest_m: float = 0.05  # metres before the sensor from which an element is drawn
    filled_beside: int = 3  # drawn pixels beside an empty one from which it is filled
