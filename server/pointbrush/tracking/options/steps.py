"""Options of the steps of a frame: predict, propose, register, label, judge, update."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from pointbrush.tracking.options.base import Options, PositiveFloat, PositiveInt


@dataclass(frozen=True, slots=True)
class SearchOptions(Options):
    """Prediction, and the part of a frame around it."""

    coarse_points: PositiveInt = 120  # model points that a hypothesis is judged by
    fine_points: PositiveInt = 400  # model points of the last iterations
    target_points: PositiveInt = 1200  # points of a sensor at most that a model is fitted to
    min_moving_points: int = 5  # moving points under which nothing is there
    radii: float = 1.5  # radii around the predictions that are searched
    radii_unknown_motion: float = 0.6  # radii added while no motion is known
    units: float = 4.0  # units added
    speed_share: float = 0.4  # share of its speed by which an object may be off its predictions
    units_per_frame: float = 2.0  # units a frame unseen by which it may be
    # Frames unseen for which both add up, and so do reaches of people's clothes and limbs.
    max_growing_frames: int = 8
    judged_units: float = 4.0  # scale in units that hypotheses are compared by
    # Radii that a large object moves until static points are no part of it.
    scenery_radii: float = 0.5
    scenery_frames: int = 2  # frames likewise, at least
    same_pose_units: float = 0.25  # units by which no model point moves between equal hypotheses
    meeting_radii: float = 1.5  # radii of both within which two predictions may meet
    explained_units: float = 3.0  # units from a prediction within which it explains a point
    # Share of the own distance within which another's is clearly nearer.
    clearly_nearer_share: float = 0.5
    # With one pose alone: boxes -.093, a street -.003, 3 pins of every second frame +.036.
    remembered_poses: PositiveInt = 4  # poses that are remembered
    pivot_ridge: float = 0.2  # weight of the regularisation of the pivot to the centre


@dataclass(frozen=True, slots=True)
class ProposalOptions(Options):
    """Pose hypotheses where no prediction fits."""

    signed: ClassVar[frozenset[str]] = frozenset({"slide_radii"})

    turn_deg: float = 40.0  # degrees of the turns that a cluster is tried with
    long_ratio: float = 1.5  # length over width from which the longest direction tells the turn
    crowd_radii: float = 0.6  # radii within which the neighbours of a seed are counted
    cluster_radii: float = 1.1  # radii within which a cluster lies
    mean_shift_rounds: int = 3  # rounds in which a cluster moves to its mean
    seeds: PositiveInt = 60  # seeds, of which the densest begins a cluster
    clusters: int = 4  # clusters that are looked at
    min_cluster_points: int = 8  # points of a cluster at least
    closed_radii: float = 1.5  # radii of a cluster that ends all round at most
    # Steps along the longest direction, in radii.
    slide_radii: tuple[float, ...] = (-0.6, -0.3, 0.3, 0.6)
    vote_step_units: PositiveFloat = 4.0  # units of a step between shifts that points vote for
    voted_shifts: int = 8  # shifts that are tried
    same_shift_steps: int = 2  # steps up to which two shifts are one
    vote_window_steps: int = 300  # steps, most voted for, among which shifts are looked for
    max_steps_across: PositiveInt = 1000  # steps across all that is seen
    alike_colour: float = 0.12  # colour difference up to which colours are alike
    palette_points: PositiveInt = 200  # model points that tell which colours an object has
    min_radius_m: PositiveFloat = (
        0.001  # metres of radius that clusters are looked for with at least
    )


@dataclass(frozen=True, slots=True)
class RelocationOptions(Options):
    """Search in the whole frame for a lost track."""

    kept_share: float = 0.85  # share of its claim under which a track is looked for elsewhere
    gain: float = 1.1  # times as much that it must have there
    others_share: float = 0.5  # share of its claim under which a place is another track's
    # Metres from its position beside the carrier within which it is searched for.
    arm_m: float = 0.6
    # Radii a frame, beside its speed, by which a hidden body may be elsewhere.
    hidden_radii: float = 0.35
    shown_share: float = 0.5  # share of its points that have to show that it is there
    # Without a search in the whole frame: 3 pins -.056, a crowd -.049.
    doubt: float = 0.25  # cost of a fit above which a track is looked for in the whole frame
    clear_cost: float = 0.3  # cost up to which it is found there
    better_ratio: float = 0.7  # share of its former cost that it must have there at most
    matched_share: float = 0.6  # share of the visible model that has to be matched there
    # Share of the colours there that it showed where it was painted.
    painted_colours_share: float = 0.4
    size_share_min: float = 0.25  # least size of a cluster over the track's
    size_share_max: float = 3.0  # greatest size of a cluster over the track's
    # Share of its size that shows at least beyond its radius from predictions.
    shown_far_share: float = 0.4
    tries: int = 2  # clusters that the track is fitted to
    patient_frames: int = 2  # frames for which it is looked for in each
    retry_frames: PositiveInt = 3  # frames between two searches after that


@dataclass(frozen=True, slots=True)
class RegistrationOptions(Options):
    """Registration of a model to a frame, and the choice among hypotheses."""

    # Radii by which an object may come nearer; nearer surface is another's.
    nearer_radii: float = 1.0
    # Units nearer or farther from which a measurement hides or sees through.
    occlusion_units: float = 4.0
    unseen_cost: float = 0.6  # cost of a pose that shows nothing of the model
    unseen_weight: float = 0.1  # weight of that cost, in models
    # Visible model points from which the hidden ones are left out of a fit.
    min_visible_points: int = 20
    # Scales in units of the iterations from a prediction.
    predicted_scales: tuple[PositiveFloat, ...] = (3.0, 3.0, 3.0, 2.5)
    # Scales in units of the iterations from anywhere.
    anywhere_scales: tuple[PositiveFloat, ...] = (10.0, 7.0, 5.0, 4.0, 3.0, 3.0)
    # Scales in units of the iterations of the best hypothesis.
    final_scales: tuple[PositiveFloat, PositiveFloat, PositiveFloat] = (2.5, 2.0, 2.0)
    # Without other hypotheses: 3 pins -.356, a street -.143.
    tries: int = 6  # hypotheses that are fitted beside the predictions
    tries_unknown_motion: int = 18  # hypotheses that are fitted while the motion is unknown
    rest_units: float = 1.0  # units by which a resting object seems to move at most
    # Units, for a lidar's first scans, because objects slip along the rings.
    rest_units_first_scans: float = 3.0
    rest_units_moving_scanner: float = 1.5  # units, for a lidar on the move
    rest_cost: float = 0.03  # cost by which the resting pose may be worse than the best
    open_share: float = 0.6  # share of facing surface from which motion can be told
    same_pose_units: float = 1.0  # units by which two equal hypotheses differ at most when judged
    doubt: float = 0.27  # cost of the best prediction above which other places are tried
    doubt_body: float = 0.6  # the same for bodies, which bend and never fit well
    averted_cost: float = 0.3  # cost of a pose that turns away all of the side that was seen
    clear_cost: float = 0.12  # cost at which nothing else is tried though the motion is unknown
    good_cost: float = 0.2  # cost at which the next hypothesis is not tried
    # Cost over the best one's up to which the next hypothesis is tried.
    try_next_ratio: float = 1.25
    nodes_per_radius: PositiveInt = 5  # deformation nodes along the radius
    node_units: float = 3.0  # units between nodes at least
    pull_units: float = 4.0  # units within which nodes are pulled to the data
    judged_units: PositiveFloat = 3.0  # scale in units that fits are judged by
    judged_units_unfitted: PositiveFloat = 6.0  # the same, of hypotheses without a registration
    judged_units_rest: PositiveFloat = 2.0  # the same, of objects at rest
    retry_frames: PositiveInt = 4  # frames between two searches elsewhere that found nothing better
    other_place_radii: float = 0.5  # radii between two hypotheses at different places
    # Cost of a pose far from every prediction, or turned half round against all of them.
    surprise_cost: float = 0.6
    surprise_radii: PositiveFloat = 3.0  # radii a frame unseen from which a pose is far
    limit_radii: float = 0.5  # radii by which a scanned object may be off its predictions
    limit_radii_unknown: float = 1.5  # the same, while its motion is unknown
    limit_units: float = 3.0  # units a frame unseen that add to it
    beyond_cost: float = 2.0  # cost of a pose beyond that limit
    # Scales of a fit within which points are paired, and beyond which a distance costs no more.
    pair_scales: PositiveFloat = 3.0
    min_pairs: int = 6  # pairs that tell a turn
    on_units: float = 3.0  # units from a surface within which points are on it
    beside_units: float = 6.0  # units within which points are beside it
    # Without: 3 pins -.088, a crowd -.035.
    excess_cost: float = 0.3  # cost of as many points beside a surface as on it


@dataclass(frozen=True, slots=True)
class DeformationOptions(Options):
    """Deformation graph of bending objects."""

    nodes_per_point: PositiveInt = 4  # nearest nodes that move a point
    nodes_around: PositiveInt = 6  # nodes that smooth a node's motion, itself among them
    rounds: int = 3  # rounds of pairing
    round_shrink: float = 0.5  # round n has the scale divided by 1 + n times this
    pair_scales: float = 3.0  # scales of a round within which points are paired
    smooth_weight: float = 0.5  # weight of the mean over the nodes around in a node's motion
    previous_weight: PositiveFloat = (
        0.5  # weight with which a node stays where the round before left it
    )


@dataclass(frozen=True, slots=True)
class ClaimOptions(Options):
    """Points that a registered model claims."""

    hiding_units: float = 3.0  # units by which an occluding surface beside a pixel is nearer
    hiding_px: int = 2  # pixels aside at which it is looked for
    hiding_share: float = 0.05  # share of the points beside it up to which it hides nothing
    reaches: float = 2.2  # reaches of a model, in place, within which it claims points
    reaches_coloured: float = 3.5  # reaches in place and colour likewise
    shaded_reaches: float = 1.2  # reaches in place within which no colour is too unlike
    # Reaches within which also a point that has not moved may be claimed.
    still_reaches: float = 1.5
    # Reaches from confirmed surface within which a point is claimed in any case.
    firm_reaches: float = 0.9
    sharp_cost: float = 0.2  # cost of a fit up to which its pose tells places beside it apart
    foot_reaches: float = 0.6  # the same for points on the ground before a lidar on the move
    new_reaches: float = 5.0  # reaches within which new points are not held against it later
    own_colour_steps: int = 20  # steps by which surface of colours that nothing else has goes on
    min_claim_points: int = 5  # points of a claim beside which new surface is looked for
    coloured_units: float = 2.0  # units in place and colour between points of new surface
    coloured_units_bent: float = 3.0  # the same, of what bends
    bent_colour_weight: float = 0.2  # share of the weight of colour for what bends
    bent_steps: int = 8  # steps by which new surface of what bends goes on in a frame
    touching_units: float = 3.0  # units within which others touch them


@dataclass(frozen=True, slots=True)
class GrowthOptions(Options):
    """New surface of objects alone in the air."""

    above_one: ClassVar[frozenset[str]] = frozenset({"new_size_share", "end_on_ratio"})

    step_units: float = 2.5  # units from point to point of connected surface
    # Without whole objects in the air: 3 pins -.129, boxes -.031.
    max_steps: int = 20  # such steps from known surface to its end at most
    max_steps_unknown: int = 40  # the same, while its length is unknown
    # Frames alone in the air from which its length is known, and times the length of its known part
    # that an object painted end on has.  Without: 3 pins of seed 43, eight draws, -.11.
    known_frames: int = 4
    end_on_ratio: float = 2.0
    was_there_share_end_on: float = 0.6  # share of that length that was there unlabelled, likewise
    # A side that turns towards a camera: see ``steps.grow``.
    side_units: float = 4.0  # units from known surface within which it begins
    side_radii: float = 0.5  # radii beyond known surface within which it ends
    side_cost: float = 0.4  # cost of a fit over which none is looked for
    side_turn_deg: float = 7.0  # turn within the remembered poses from which one comes into view
    flat_units: float = 0.6  # units of its deviation from a plane
    hand_m: float = 0.02  # metres of deviation across that a flat part of a hand has at most
    new_share: float = 0.5  # share of the known points that new surface has at most
    new_share_moving_scanner: float = 1.2  # the same, before a lidar on the move
    new_points: int = 10  # points of new surface that are allowed in any case
    new_size_share: float = 1.8  # share of its size that it has at most with new surface
    longer_radii: float = 2.0  # radii beyond where it was looked for in which it may end
    along_share: float = 0.75  # share of much new surface that was beside it and has gone along
    # Share of new surface that was there unlabelled, where it is cut off.
    was_there_share_cut: float = 0.2
    was_there_share_open: float = 0.7  # the same, where it stands free
    # Share of colours never seen on it, from which new surface may be a hand.
    strange_colours_share: float = 0.5
    strange_size_share: float = 0.05  # share of its size that such new surface has at least


@dataclass(frozen=True, slots=True)
class ContextOptions(Options):
    """Unlabelled surface beside a track."""

    explained_units: float = 4.0  # units from unlabelled surface within which it explains a point
    yield_ratio: float = 0.7  # share of its cost at which it takes a point from a claim
    stayed_units: float = 7.0  # units within which unlabelled surface is where it was
    rest_units: float = 0.25  # units by which an object that stays moves at most
    reach_m: float = 1.0  # metres about an object within which whoever may hold it is
    beside_radii: float = 0.5  # radii about an object within which unlabelled surface is beside it
    beside_units: float = 4.0  # units likewise
    # Without: 3 pins -.034.
    max_points: PositiveInt = 1000  # unlabelled points of a sensor kept beside an object


@dataclass(frozen=True, slots=True)
class FlyingPixelOptions(Options):
    """Flying pixels at outlines."""

    behind_units: float = 4.0  # units by which a flying pixel lies behind a neighbour
    level_units: float = 2.0  # units within which a neighbour is as deep
    painted_share: float = 0.5  # share of them in the painting from which a label keeps them
    min_pixels: int = 20  # flying pixels that tell it
    # Without flying pixels: boxes -.004, a crowd -.009, 3 pins +.011.
    outline_behind_units: float = 6.6  # units by which a flying pixel lies behind the object
    outline_level_units: float = 4.6  # units within which pixels are as deep
    outline_few: int = 2  # pixels as deep up to which hardly any are


@dataclass(frozen=True, slots=True)
class GroundContactOptions(Options):
    """Ground that was painted with an object."""

    # Share of the ground in its outline in the painting from which it keeps it.
    painted_share: float = 0.5
    min_points: int = 20  # points of that ground that tell it: feet are few
    min_corners: int = 4  # model points that have an outline
    below_m: float = 0.3  # metres under the model down to which the ground is its
    beside_m: float = 1.0  # metres beside the model within which the ground tells its plane
    # Median distances of the ground from that plane from which a point above it is of no ground.
    ground_medians: float = 6.0
    feet_m: float = 1.0  # metres above it up to which an object's lowest part goes


@dataclass(frozen=True, slots=True)
class ComponentOptions(Options):
    """Connected components of points."""

    cell_units: PositiveFloat = 1.5  # units of a cell of connected components
    touching_cells: float = 1.75  # cells between the middles of two that touch
    crumb_share: float = 0.04  # share of a label under which a piece apart is no part of it
    crumb_points: int = 10  # points of such a piece
    apart_factor: float = 3.0  # times as far apart as that for whole pieces


@dataclass(frozen=True, slots=True)
class MeanFieldOptions(Options):
    """Mean field over cells."""

    sweeps: int = 30  # sweeps over the cells at most
    neighbour_weight: float = 8.0  # weight of all neighbours of a cell against its own cost
    settled_change: float = 0.02  # change of probability under which a sweep was the last
    same_change: float = 0.002  # change of which no neighbour need know
    full_neighbours: PositiveFloat = 3.0  # neighbours from which they have their full weight


@dataclass(frozen=True, slots=True)
class VerdictOptions(Options):
    """Whether a registered track is there."""

    min_facing_points: int = 10  # model points that must face the sensor for their side to count
    surface_units: float = 2.5  # units from the model within which a point is of its surface
    hidden_units: int = 3  # units by which a measurement before a model point hides it
    # Units by which a measurement lies behind a point that is seen through.
    seen_through_units: int = 4
    present_share: float = 0.25  # share of the visible model that has to be matched for presence
    min_points: int = 4  # points that a present object has at least
    min_size_share: float = 0.01  # the same, as a share of its size
    min_trust_share: float = 0.4  # share of its confidence kept when next to nothing shows
    remaining_share: float = 0.1  # share of its last points from which a scanned object is there


@dataclass(frozen=True, slots=True)
class UpdateOptions(Options):
    """Update of a track from a frame."""

    correction_min_points: int = 20  # painted points from which a pose is found among them
    correction_max_cost: float = 0.3  # cost up to which a model fits the painted points
    correction_explained_share: float = 0.6  # share of the painted points that it has to explain
    # Units from the model within which a point that is surely the object's is new surface:
    # painted, alone, or in lidar scans, where other points within them may be its own too.
    new_surface_units: float = 8.0
    colour_points: PositiveInt = 1000  # sampled points for comparisons with painted colours
    teach_units: float = 3.0  # units from the model within which points and new surface teach it
    size_matched_share: float = 0.8  # share of the model found from which its size is learnt
    forgotten_frames: int = 15  # frames out of sight after which bending surface is given up
    lost_frames: int = 45  # frames that an object is looked for before it is lost
    teach_cost: float = 0.25  # cost under which a fit teaches the model
    motion_cost: float = 0.4  # cost over which a fit says nothing about the motion
    reappear_share: float = 0.6  # share of inliers that ends an occlusion
    usual_cost_rate: float = 0.1  # weight of a frame in the usual cost
    scrap_share: float = 0.05  # share of a large object's size that tells no motion
    # Without: boxes -.046.
    hiding_log_colour: float = 0.6  # mean log ratio of colours of an occluding object
    clear_share: float = 0.5  # share of size and facing surface of a clearly visible object
    # Confidence up to which an object found elsewhere may be another.
    astray_confidence: float = 0.45
    astray_radii: float = 0.5  # radii from all predictions from which that is so
    stayed_share: float = 0.35  # share of inliers that is enough for an object at its last place
