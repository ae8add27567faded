"""Options of the joint tracking of people."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt


@dataclass(frozen=True, slots=True)
class BodyOptions(Options):
    """Bodies in front of a known scene: cells, components, people tracked jointly."""

    cell_units: PositiveFloat = 3.0  # size of a cell in units
    cell_radius_share: float = 0.045  # share of the figure's radius that a cell is at least
    disputed_share: float = 0.3  # share of the smaller claim from which two tracks dispute a body
    distinct_log: float = 1.4  # log ratio from which a colour is one track's alone
    # Minimum share of a carried object's colours that are clearly not colours of clothes.
    carried_share: float = 0.15
    # Share of its carrier's points from which a missing object may be among them.
    carried_size_share: float = 0.5
    # Cells from the static scene within which unlabelled points belong to it.
    scene_cells: float = 1.5
    # Radii around a person's expected position in which clothes are searched for, plus the same for
    # each frame unseen.
    clothes_radii: float = 0.2
    sampled_points: PositiveInt = 4000  # sampled moving points for tests of contact
    touching_cells: float = 1.7  # distance of cells that touch, in cells
    thin_share: float = 0.15  # share of the usual number of points under which a cell leads nowhere
    # Share of the longest path within which a separate part is a figure's.
    bridge_share: float = 0.25
    clothed_cells: int = 12  # cells from which the clothes of a part are identified
    # Mean log ratio by which colours are clearly another's: of a part, of a person's cells, of
    # exchanged people.
    clearly_log: float = 0.7
    # Share of the points of a cell, of a part, or of the claims on a body, that decide.
    majority_share: float = 0.5
    # Share of a part's cells that have the colours of the figure beside it.
    alike_cells_share: float = 0.6
    min_claim_share: float = 0.03  # share of a body that its owner has to have claimed
    min_part_cells: int = 4  # cells of a separate part
    way_radii: PositiveFloat = 0.6  # share of the figure's radius at which a path ends
    cell_sigmas: float = 4.5  # deviations of the depth noise that a cell has at least
    limb_share: float = 0.1  # share of a person's radius that is a limb: the largest cell
    forgotten_frames: int = 5  # frames unseen after which an unlabelled person is forgotten
    crowded_ratio: float = 1.3  # ratio to a person's usual cells that is too many for one person
    # Metres by which a person is spread along the ground, a standard deviation.
    spread_m: float = 0.2
    # Metres below which a position is as expected, and beyond which it is no other person's.
    nearest_m: tuple[PositiveFloat, PositiveFloat] = (0.1, 1.0)
    sure_likelihood: float = 0.75  # likelihood from which a frame updates stature and clothes
    better_ratio: float = 1.5  # ratio of visible surface from which clothes are updated
    touching_share: float = 0.02  # maximum share of it that touches other people
    doubted_confidence: float = 0.4  # maximum confidence of a person who may be another
    head_m: float = 0.2  # metres by which a head is above the highest touch with another
    heads_apart_m: float = 0.25  # minimum metres along the ground between two people
    head_lower_m: float = 0.6  # maximum metres between the heights of two heads
    # Without joint tracking of people: boxes -.010, a crowd -.028.
    limb_m: float = 0.1  # maximum metres between points of a person: the thickness of limbs
    # Change of colour at which the agreement of cells is a third, and a path twice as long.
    colour_change: PositiveFloat = 0.08
    colour_points: PositiveInt = 400  # sampled points for comparisons of colour
    # Metres by which a nearer surface occludes a place, and by which surface above a top is behind.
    before_m: float = 0.15
    seen_min_cells: int = 4  # cells under which a person is not seen
    seen_min_share: float = 0.02  # share of their most cells likewise
    scrap_share: float = 0.3  # share of their most under which they may be elsewhere
    # Metres along the ground from the middle within which surface is remembered.
    memory_m: float = 0.6
    memory_cells: float = 2.0  # cells from visible surface at which hidden surface is remembered
    memory_behind_m: float = 0.1  # metres by which it must be hidden
    # Metres from the middle of visible surface beyond which none is remembered.
    memory_seen_m: float = 1.3
    newest_step_weight: float = 0.7  # weight of the newest step in the expected one
    hidden_step_share: float = 0.7  # share of the last step that a hidden person moves by
    unlike_log: float = 1.5  # mean log ratio of clothes by which surface is not theirs
    most_decay: float = 0.98  # share of the most cells that counts a frame later
    gone_m: float = 0.45  # metres of motion after which all of a person has moved
    gone_frames: int = 2  # minimum frames of that motion
    way_frames: int = 60  # frames for which places are remembered


@dataclass(frozen=True, slots=True)
class StrideOptions(Options):
    """Strides of people, and the assignment of cells."""

    stride_m: float = 0.08  # metres by which a stride varies
    stride_share: float = 0.45  # share of the last stride by which it varies
    stride_m_per_frame: float = 0.05  # metres more for each frame unseen
    max_unseen_frames: int = 6  # frames unseen after which the search grows no more
    sampled_cells: PositiveInt = 120  # cells by which a place is judged
    same_depth_m: PositiveFloat = 0.2  # metres within which surface is as deep as it should be
    hidden_cost: float = 0.55  # cost of a cell that is hidden; one seen through costs 1
    unknown_cost: float = 0.5  # cost of a cell where nothing is measured
    depth_weight: float = 0.6  # weight of depth where it is measured
    colour_weight: float = 0.7  # weight of colour where it is measured
    other_colour: PositiveFloat = 0.1  # difference of another colour
    # Weight of the mean cost against half a squared deviation of the stride.  Without: a crowd
    # -.002.
    evidence_weight: float = 14.0
    own_cells: float = 1.5  # cells from a person within which a cell is theirs
    limbs_m: PositiveFloat = 0.06  # metres by which limbs move anyhow
    swing_share: float = 0.4  # share of the fastest step by which limbs swing
    slowest_m: float = 0.02  # metres of that step at least
    fastest_m: float = 0.3  # metres of that step at most
    limbs_m_per_frame: float = 0.04  # metres more for each frame unseen
    shade: PositiveFloat = 0.06  # difference of colour that counts as much as that distance
    cap: float = 4.0  # cost of a cell that is nowhere near a person
    clothes_weight: float = 0.35  # weight of clothes
    clothes_rarer_log: float = 0.5  # mean log ratio by which colours are rarer than usual ones
    clothes_max_log: float = 4.0  # greatest log ratio that counts
    hidden_cost_owner: float = 1.0  # cost of a cell for a person hidden in the last frame
    body_m: float = 0.25  # metres from the middle, along the ground, that hold a body
    body_sigma_m: PositiveFloat = 0.2  # metres of deviation beyond
    body_max_cost: float = 2.0  # cost beyond at most
    rounds: PositiveInt = 3  # maximum number of corrections of strides
    settled_m: float = 0.02  # metres up to which one correction is enough
    visible_doubt: float = 0.15  # visible share at which a correction is half believed
    corrected_share: float = 0.03  # share of their cells that a person has to have for a correction
    met_swings: float = 2.5  # swings of limbs within which cells meet a person's surface
    fitting_cap_share: float = 0.8  # share of the cap that fits
    fitting_cells_share: float = 0.2  # share of its cells that must fit for a body to be a person's
    # Probability from which an outline far from all people is a person's.
    sure_probability: float = 0.9
    apart_m: float = 0.35  # metres of nothing between a part and the rest of a person
    apart_share: float = 0.5  # share of the rest that such a part has at most
    known_m: float = 0.15  # metres from a person's surface within which it may lie all the same
    known_beside_m: float = 0.5  # metres from their middle likewise
    disputed_cost: float = 1.0  # cost less than another's by which a cell is disputed


@dataclass(frozen=True, slots=True)
class ArrivalOptions(Options):
    """People entering, returning or exchanged with each other."""

    # Without unlabelled people: a crowd -.005.
    min_cells: int = 12  # cells from which a body may be a new person
    min_share: float = 0.12  # share of the usual number of cells likewise
    back_min_cells: int = 6  # cells from which a body may be a missing person
    back_min_share: float = 0.05  # share of the usual number of cells likewise
    missing_frames: int = 3  # frames missing from which a part of another may be theirs
    part_share: float = 0.2  # share of the usual number of cells that such a part has
    unclaimed_share: float = 0.7  # share of a connected body that must be no track's
    back_m: PositiveFloat = 0.3  # metres from a missing person's expected position
    back_m_per_frame: float = 0.2  # metres more for each frame missing
    back_max_frames: int = 10  # frames missing for which that adds up
    clothes_weight: float = 0.5  # weight of clothes against the distance
    stature_weight: float = 0.25  # weight of stature against the distance
    unlabelled_cost: float = 0.5  # cost of a body that was tracked without a label
    # Log ratio of clothes from which a body is certainly not the other's.
    decisive_log_clothes: float = 0.3
    # Metres along the ground about a person within which new surface is theirs.
    around_m: float = 0.6
    joined_m: float = 0.3  # metres between unlabelled bodies that come together
    touches_m: float = 0.1  # metres between a body and a returned person
    side_px: int = 8  # pixels from the left or right edge of the picture
    side_points: int = 5  # points within them from which a person may have left there
    return_tops: PositiveInt = 3  # measured tops of a newcomer from which they may be recognised
    return_frames: PositiveInt = 5  # frames after which they may be without
    return_clothes_weight: float = 0.5  # weight of clothes, which light changes, against stature
    return_seconds: PositiveFloat = 1.5  # seconds in which the odds of a return fall to 1/e
    return_m: PositiveFloat = 0.7  # metres, a deviation, between the places of leaving and entering
    return_soon_log: float = 4.0  # log odds of a return at once, at the same place
    return_log_odds: float = 1.8  # log odds that a newcomer is another person otherwise
    recent_frames: int = 3  # frames within which a person has just come
    exchange_log: float = 0.5  # mean log ratio by which each must be more like the other's clothes
    exchange_frames: int = 3  # consecutive frames in which that is required
    # Mean log ratio by which a body may be less like a person's clothes than another's.
    return_log: float = 0.1
    # Radii around a person's expected position in which they may reappear.
    return_radii: float = 0.5
    return_radii_per_frame: float = 0.25  # radii more for each frame unseen
    # Share of a hardly visible object that a body must have to be it.
    return_scrap_share: float = 0.25
    return_edge_cost: float = 0.5  # cost of a body at the limit of a figure's reach


@dataclass(frozen=True, slots=True)
class StatureOptions(Options):
    """Stature of people, and the vertical."""

    sampled_points: PositiveInt = 50  # sampled points for a person's distance
    top_share: float = 0.01  # share of a person's points above their measured top
    # Metres above their top in which only surface behind them may be visible.
    above_m: tuple[float, float] = (0.12, 0.25)
    sigma_m: PositiveFloat = 0.02  # metres by which a measured top varies
    bent_share: float = 0.1  # share of the frames in which a person bends, sits or lifts an arm
    bent_range_m: PositiveFloat = 1.0  # metres of the range of their top in these frames
    min_tops: int = 2  # measured tops from which a stature is known
    decisive_log_odds: float = 3.0  # log odds (20 to 1) that decide between two people
    # Cosine of the picture's downward axis and the vertical, under which it is unknown.
    leaning_cos: float = 0.7
    level_stride: PositiveInt = 3  # stride of the points in the search for level planes
    level_points: int = 300  # minimum points on a level plane
    level_sigma_m: float = 0.3  # metres of their deviation along its shorter side
    patch_m: PositiveFloat = 0.4  # metres of a patch of surface
    patch_points: int = 20  # points that it has to have
    patch_flatness: float = 0.1  # variance through it over the lesser along it at most
    patch_cos: float = 0.85  # cosine of its angle to the rough vertical at most
    # Metres about the level that are fitted, one after the other.
    fit_m: tuple[float, float, float] = (0.12, 0.06, 0.06)
