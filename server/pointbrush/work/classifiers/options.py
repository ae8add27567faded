"""Limits of classifiers, and options for applying one."""

from __future__ import annotations

from dataclasses import dataclass, field

from pointbrush.classify.options import DoubtOptions, FeatureOptions, ForestOptions


@dataclass(frozen=True, slots=True)
class ClassifierOptions:
    """Sizes and counts; all above 0."""

    features: FeatureOptions = field(default_factory=FeatureOptions)
    forest: ForestOptions = field(default_factory=ForestOptions)
    doubt: DoubtOptions = field(default_factory=DoubtOptions)
    memory_bytes: int = 384 * 2**20
    """Size of the cache of features, bytes."""
    whole_points: int = 2_000_000
    """Points of the largest frame that is processed whole; larger frames are split into pieces."""
    view_points: int = 1_000_000
    """Points around a place of a larger frame that are processed for a preview."""
    piece_points: int = 1_000_000
    """Limit of points in a piece, without its margin."""
    margin: float = 48.0
    """Width of the margin around a piece, cells."""
    frame_examples: int = 8_000
    """Limit of examples per frame, balanced between classes."""
    taught_frames: int = 24
    """Limit of painted training frames per recording, evenly spaced."""
    taught_places: int = 16
    """Limit of training places per large frame."""
    taught_points: int = 200_000
    """Points around such a place that are processed."""
    looked_frames: int = 6
    """Number of frames of a recording that are searched for uncertain places."""
    looked_recordings: int = 4
    """Number of recordings of a workspace that are searched for uncertain places."""
