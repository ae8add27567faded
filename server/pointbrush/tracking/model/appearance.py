"""Appearance of an object: a histogram of its colours in the painted frame."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter

from pointbrush.compiled import compiled
from pointbrush.tracking.compute.grid import numbered
from pointbrush.tracking.interface import F32, I64, Mask
from pointbrush.tracking.options.tracks import AppearanceOptions

BIN = 0.028
"""Width of a bin, in the units of ``View.colour``."""
LIKE = 3
"""Width, in bins along each axis, of the neighbourhood of similar colours."""
LOW, SHAPE = (-1.72, -2.04, 0.0), (124, 146, 11)
"""Minimum and number of bins of each channel of ``View.colour``; the last is brightness."""


@dataclass(frozen=True, slots=True, eq=False)
class ColourHistogram:
    """``common`` (bins,): share of an object's points with a similar colour.

    ``hues`` (bins,): the same at any brightness; ``usual``: ``likeness`` of its own colours;
    ``alone`` (bins,): mask of colours that are common here and rare elsewhere.
    """

    options: AppearanceOptions
    common: F32
    hues: F32
    usual: float
    alone: Mask

    @staticmethod
    def of(colour: F32, options: AppearanceOptions) -> ColourHistogram:
        """Return the histogram of an object's colours (M, 3); see ``View.colour``."""
        count = np.bincount(_bins(colour), minlength=int(np.prod(SHAPE)))
        share = (count / max(len(colour), 1)).astype(np.float32).reshape(SHAPE)
        common = LIKE**3 * uniform_filter(share, LIKE, mode="constant").ravel()
        hues = LIKE**2 * uniform_filter(share.sum(axis=2), LIKE, mode="constant").ravel()
        usual = (
            float(np.log(common[_bins(colour)] + options.absent_share).mean())
            if len(colour)
            else 0.0
        )
        return ColourHistogram(options, common, hues, usual, np.zeros(len(common), np.bool_))

    def apart_from(self, others: Iterable[ColourHistogram]) -> ColourHistogram:
        """Return a copy with ``alone`` set to the colours that are rare in ``others``."""
        options = self.options
        alone = self.common > options.common_share
        for other in others:
            alone &= self.common > options.own_colour_ratio * other.common
        return replace(self, alone=alone)

    def commoner_than(self, colour: F32, size: float) -> ColourHistogram:
        """Return a copy with ``alone`` restricted to colours that more of its points have.

        The numbers of its ``size`` points and of points with the colours (M, 3) are compared.
        """
        other = ColourHistogram.of(colour, self.options)
        return replace(self, alone=self.alone & (size * self.common > len(colour) * other.common))

    def each(self, colour: F32) -> F32:
        """Return (M,) the log share of each of the colours (M, 3)."""
        return np.asarray(
            np.log(self.common[_bins(colour)] + self.options.absent_share), np.float32
        )

    def likeness(self, colour: F32) -> float:
        """Return the mean log share of the colours (M, 3)."""
        return float(self.each(colour).mean()) if len(colour) else -np.inf

    def unlike(self, colour: F32) -> bool:
        """Return whether the colours (M, 3) are much rarer here than its own usually are."""
        return self.likeness(colour) < self.usual - self.options.rarer_log

    def overrepresented(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) far commoner in the histogram than among themselves."""
        options = self.options
        at = _at(colour)
        cell = _flat(at // options.coarse_bins)
        number = numbered(cell)
        return np.asarray(
            self.common[_flat(at)]
            > options.own_colour_ratio * np.bincount(number)[number] / len(colour)
        )

    def only(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) that this histogram alone has."""
        return np.asarray(self.alone[_bins(colour)])

    def strange(self, colour: F32) -> Mask:
        """Mark the colours (M, 3) without a similar hue in the histogram, be they brighter or
        darker."""
        return np.asarray(self.hues[_bins(colour) // SHAPE[2]] <= self.options.strange_share)

    def share(self, colour: F32) -> float:
        """Return the share of the colours (M, 3) with a similar colour here."""
        return (
            float((self.common[_bins(colour)] > self.options.absent_share).mean())
            if len(colour)
            else 0.0
        )


@compiled
def _at(colour: F32) -> I64:
    """Return (M, 3) the bin of each of the colours along each channel."""
    at = np.empty(colour.shape, np.int64)
    for i in range(len(colour)):
        for a in range(3):
            number = int((colour[i, a] - LOW[a]) / BIN)
            at[i, a] = min(max(number, 0), SHAPE[a] - 1)
    return at


@compiled
def _bins(colour: F32) -> I64:
    """Return (M,) the bin number of each of the colours (M, 3)."""
    return _flat(_at(colour))


@compiled
def _flat(at: I64) -> I64:
    """Return (M,) the number of each of the bins (M, 3)."""
    number = np.empty(len(at), np.int64)
    for i in range(len(at)):
        number[i] = (at[i, 0] * SHAPE[1] + at[i, 1]) * SHAPE[2] + at[i, 2]
    return number
