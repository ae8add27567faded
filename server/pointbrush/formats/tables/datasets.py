"""Classes of well-known datasets: templates of palettes, and the numbers that their files use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from pointbrush.errors import NotFoundError
from pointbrush.names import spelled_out


@dataclass(frozen=True, slots=True)
class ClassName:
    """A class of a map or a template; ``color`` is ``#rrggbb`` or ""."""

    name: str
    color: str = ""

    def __post_init__(self) -> None:
        """Write out characters that names must not contain."""
        object.__setattr__(self, "name", spelled_out(self.name))


@dataclass(frozen=True, slots=True)
class Dataset:
    """A dataset's classes by their number in its files; ``name`` is that of the template."""

    name: str
    title: str
    classes: Mapping[int, ClassName]


def _dataset(name: str, title: str, rows: str) -> Dataset:
    """A dataset of lines ``number name #rrggbb``."""
    classes = {}
    for row in rows.split("\n"):
        if words := row.split():
            classes[int(words[0])] = ClassName(" ".join(words[1:-1]), words[-1])
    return Dataset(name, title, MappingProxyType(classes))


SEMANTIC_KITTI = _dataset(
    "semantickitti",
    "SemanticKITTI",
    # semantic-kitti.yaml of the benchmark's API; moving classes apart.
    """
    1 outlier #ff0000
    10 car #6496f5
    11 bicycle #64e6f5
    13 bus #6450fa
    15 motorcycle #1e3c96
    16 on-rails #0000ff
    18 truck #501eb4
    20 other-vehicle #0000ff
    30 person #ff1e1e
    31 bicyclist #ff28c8
    32 motorcyclist #961e5a
    40 road #ff00ff
    44 parking #ff96ff
    48 sidewalk #4b004b
    49 other-ground #af004b
    50 building #ffc800
    51 fence #ff7832
    52 other-structure #ff9600
    60 lane-marking #96ffaa
    70 vegetation #00af00
    71 trunk #873c00
    72 terrain #96f050
    80 pole #fff096
    81 traffic-sign #ff0000
    99 other-object #32ffff
    252 moving-car #6496f5
    253 moving-bicyclist #ff28c8
    254 moving-person #ff1e1e
    255 moving-motorcyclist #961e5a
    256 moving-on-rails #0000ff
    257 moving-bus #6450fa
    258 moving-truck #501eb4
    259 moving-other-vehicle #0000ff
    """,
)
NUSCENES = _dataset(
    "nuscenes",
    "nuScenes lidarseg",
    # category.json of nuScenes-lidarseg, colours of the development kit; 0 is noise.
    """
    1 animal #4682b4
    2 human.pedestrian.adult #0000e6
    3 human.pedestrian.child #87ceeb
    4 human.pedestrian.construction_worker #6495ed
    5 human.pedestrian.personal_mobility #db7093
    6 human.pedestrian.police_officer #000080
    7 human.pedestrian.stroller #f08080
    8 human.pedestrian.wheelchair #8a2be2
    9 movable_object.barrier #708090
    10 movable_object.debris #d2691e
    11 movable_object.pushable_pullable #696969
    12 movable_object.trafficcone #2f4f4f
    13 static_object.bicycle_rack #bc8f8f
    14 vehicle.bicycle #dc143c
    15 vehicle.bus.bendy #ff7f50
    16 vehicle.bus.rigid #ff4500
    17 vehicle.car #ff9e00
    18 vehicle.construction #e9967a
    19 vehicle.emergency.ambulance #ff5300
    20 vehicle.emergency.police #ffd700
    21 vehicle.motorcycle #ff3d63
    22 vehicle.trailer #ff8c00
    23 vehicle.truck #ff6347
    24 flat.driveable_surface #00cfbf
    25 flat.other #af004b
    26 flat.sidewalk #4b004b
    27 flat.terrain #70b43c
    28 static.manmade #deb887
    29 static.other #ffe4c4
    30 static.vegetation #00af00
    31 vehicle.ego #fff0f5
    """,
)
LAS = _dataset(
    "las",
    "ASPRS LAS classes",
    # LAS 1.4 R15, table 17; 0 and 1 are unclassified points.
    """
    2 Ground #a0522d
    3 Low Vegetation #9acd32
    4 Medium Vegetation #3cb371
    5 High Vegetation #006400
    6 Building #ff8c00
    7 Low Noise #ff0000
    8 Model Key-Point #ffd700
    9 Water #1e90ff
    10 Rail #708090
    11 Road Surface #696969
    13 Wire - Guard #ffe4b5
    14 Wire - Conductor #ffff00
    15 Transmission Tower #8a2be2
    16 Wire-Structure Connector #da70d6
    17 Bridge Deck #bc8f8f
    18 High Noise #dc143c
    19 Overhead Structure #cd853f
    20 Ignored Ground #deb887
    21 Snow #f0f8ff
    22 Temporal Exclusion #c71585
    """,
)
SCANNET = _dataset(
    "scannet",
    "ScanNet-20",
    # NYU40 numbers of the benchmark's 20 classes, and its colours.
    """
    1 wall #aec7e8
    2 floor #98df8a
    3 cabinet #1f77b4
    4 bed #ffbb78
    5 chair #bcbd22
    6 sofa #8c564b
    7 table #ff9896
    8 door #d62728
    9 window #c5b0d5
    10 bookshelf #9467bd
    11 picture #c49c94
    12 counter #17becf
    14 desk #f7b6d2
    16 curtain #dbdb8d
    24 refrigerator #ff7f0e
    28 shower curtain #9edae5
    33 toilet #2ca02c
    34 sink #7080a0
    36 bathtub #e377c2
    39 otherfurniture #5254a3
    """,
)
DATASETS: Mapping[str, Dataset] = MappingProxyType(
    {each.name: each for each in (SEMANTIC_KITTI, NUSCENES, LAS, SCANNET)}
)


def dataset_named(name: str) -> Dataset:
    """Return the dataset called ``name``; raise NotFoundError with the list of datasets."""
    if name not in DATASETS:
        raise NotFoundError(f"template: expected one of {', '.join(DATASETS)}, got {name[:40]!r}")
    return DATASETS[name]
