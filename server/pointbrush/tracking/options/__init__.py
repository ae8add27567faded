"""The tunable numbers of `auto`: one tree of frozen dataclasses, grouped by step."""

from __future__ import annotations

from dataclasses import dataclass, field

from pointbrush.tracking.options.base import Options
from pointbrush.tracking.options.confidence import (
    ConfidenceOptions,
    IcpConfidenceOptions,
    PersonConfidenceOptions,
)
from pointbrush.tracking.options.people import (
    ArrivalOptions,
    BodyOptions,
    StatureOptions,
    StrideOptions,
)
from pointbrush.tracking.options.sensors import (
    BackgroundOptions,
    DepthNoiseOptions,
    GroundOptions,
    LensOptions,
    MappingOptions,
    RangeImageOptions,
    ScanOdometryOptions,
    SwayOptions,
    TintOptions,
    ViewpointOptions,
    VisualOdometryOptions,
)
from pointbrush.tracking.options.steps import (
    ClaimOptions,
    ComponentOptions,
    ContextOptions,
    DeformationOptions,
    FlyingPixelOptions,
    GroundContactOptions,
    GrowthOptions,
    MeanFieldOptions,
    ProposalOptions,
    RegistrationOptions,
    RelocationOptions,
    SearchOptions,
    UpdateOptions,
    VerdictOptions,
)
from pointbrush.tracking.options.tracks import (
    AppearanceOptions,
    CompanionOptions,
    IdentityOptions,
    JumpOptions,
    ObjectOptions,
    SmoothingOptions,
    StrainOptions,
    SurfaceOptions,
)


@dataclass(frozen=True, slots=True)
class TrackerOptions(Options):
    """All options of `auto`; experiments use other values of this type."""

    companions: CompanionOptions = field(default_factory=CompanionOptions)
    jumps: JumpOptions = field(default_factory=JumpOptions)
    lens: LensOptions = field(default_factory=LensOptions)
    range_image: RangeImageOptions = field(default_factory=RangeImageOptions)
    viewpoint: ViewpointOptions = field(default_factory=ViewpointOptions)
    tint: TintOptions = field(default_factory=TintOptions)
    ground: GroundOptions = field(default_factory=GroundOptions)
    visual_odometry: VisualOdometryOptions = field(default_factory=VisualOdometryOptions)
    scan_odometry: ScanOdometryOptions = field(default_factory=ScanOdometryOptions)
    sway: SwayOptions = field(default_factory=SwayOptions)
    background: BackgroundOptions = field(default_factory=BackgroundOptions)
    noise: DepthNoiseOptions = field(default_factory=DepthNoiseOptions)
    mapping: MappingOptions = field(default_factory=MappingOptions)
    search: SearchOptions = field(default_factory=SearchOptions)
    propose: ProposalOptions = field(default_factory=ProposalOptions)
    relocate: RelocationOptions = field(default_factory=RelocationOptions)
    register: RegistrationOptions = field(default_factory=RegistrationOptions)
    deform: DeformationOptions = field(default_factory=DeformationOptions)
    claim: ClaimOptions = field(default_factory=ClaimOptions)
    growth: GrowthOptions = field(default_factory=GrowthOptions)
    context: ContextOptions = field(default_factory=ContextOptions)
    flying: FlyingPixelOptions = field(default_factory=FlyingPixelOptions)
    ground_contact: GroundContactOptions = field(default_factory=GroundContactOptions)
    link: ComponentOptions = field(default_factory=ComponentOptions)
    mean_field: MeanFieldOptions = field(default_factory=MeanFieldOptions)
    verdict: VerdictOptions = field(default_factory=VerdictOptions)
    confidence: ConfidenceOptions = field(default_factory=ConfidenceOptions)
    update: UpdateOptions = field(default_factory=UpdateOptions)
    strain: StrainOptions = field(default_factory=StrainOptions)
    surface: SurfaceOptions = field(default_factory=SurfaceOptions)
    appearance: AppearanceOptions = field(default_factory=AppearanceOptions)
    track: ObjectOptions = field(default_factory=ObjectOptions)
    identity: IdentityOptions = field(default_factory=IdentityOptions)
    smoothing: SmoothingOptions = field(default_factory=SmoothingOptions)
    body: BodyOptions = field(default_factory=BodyOptions)
    step: StrideOptions = field(default_factory=StrideOptions)
    arrivals: ArrivalOptions = field(default_factory=ArrivalOptions)
    stature: StatureOptions = field(default_factory=StatureOptions)
    person_confidence: PersonConfidenceOptions = field(default_factory=PersonConfidenceOptions)
