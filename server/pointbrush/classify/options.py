"""Tunable numbers of the classifier taught by example."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.values.classifiers import LARGEST_CELL as LARGEST_CELL
from pointbrush.values.classifiers import MOST_CLASSES as MOST_CLASSES
from pointbrush.values.classifiers import NAME_LENGTH as NAME_LENGTH

MOST_BYTES = 64 * 2**20
"""Of a classifier's file, unpacked."""
MOST_IGNORED = 1000
"""Places that a classifier ignores."""
MOST_TREES = 1_024
"""Trees in a classifier's file."""
MOST_DEPTH = 64
"""Nodes from a root to a leaf in a classifier's file: longer ways would take minutes a frame."""
SMALLEST_CELL = 1e-6
"""Metres, in a classifier's file."""
LARGEST = 1e30
"""Absolute value of a feature, threshold or deviation in a classifier's file."""


@dataclass(frozen=True, slots=True)
class FeatureOptions:
    """Sizes at which the surroundings of a cell are described; all above 0."""

    points_per_cell: float = 1.6
    """Points that a cell holds on average where the scale is found."""
    most_cells: int = 400_000
    """Cells of a frame; with more a larger size is taken."""
    levels: int = 5
    """Radii, each twice the one before."""
    coloured: tuple[int, ...] = (1, 3)
    """Levels at which the mean colour and intensity are described."""
    openings: tuple[int, ...] = (3, 9, 25)
    """Edges of windows, columns, in which objects are taken off the ground."""
    opening_column: float = 2.0
    """Edge of such a column, cells."""
    slopes: tuple[float, ...] = (0.12, 0.5)
    """Metres up per metre along that the ground may rise at most, one surface for each."""
    ground_column: float = 8.0
    """Edge of a column of the ground, cells."""
    bodies: tuple[float, ...] = (2.0, 5.0)
    """Edges of cubes, cells, that belong to one body where they are neighbours."""
    floor: float = 2.5
    """Height over the ground from which on something stands on it, cells."""


@dataclass(frozen=True, slots=True)
class ForestOptions:
    """Trees and their growth; all above 0."""

    trees: int = 32
    depth: int = 14
    """Questions from root to leaf at most."""
    fewest: int = 8
    """Examples in a leaf at least."""
    tried: int = 16
    """Features that are tried at a node, each at one random threshold."""
    most: int = 20_000
    """Examples that are learnt from at most."""
    smoothing: float = 0.1
    """Examples of each class that a leaf has seen beside its own."""
    copies: int = 8_000
    """Examples up to which each is learnt from several times."""
    shake: float = 0.2
    """Standard deviation of the noise added to a feature, relative to its own in a frame."""


@dataclass(frozen=True, slots=True)
class DoubtOptions:
    """Places that are offered to be answered; all above 0."""

    compared: int = 1500
    """Points of a frame that stand for all that are open."""
    considered: int = 128
    """Of these, places that may be asked about, more of them in doubt."""
    rarity: float = 0.4
    """Power of one over a class's share by which its doubts count."""
    edge: float = 16.0
    """Edge, cells, of a cube in which the doubts of a class count as one."""
    reach: float = 24.0
    """Cells from the middle of a piece to its border at most."""
    fewest: int = 12
    """Points of a piece that a person is asked about, at least."""
    scaled: float = 0.14
    """Metres that a cell counts as where the object tool parts scans of many views."""
