"""Single clouds of masks, several frames pooled: how sizes, outlines and places are distributed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes, distance_transform_edt, label
from scipy.spatial import cKDTree

from hcss_evaluate.measures.box_counting import boundary_boxes
from hcss_twin.providers import Array

Mask = NDArray[np.bool_]

SPECK = 2
"""Pixels of the largest clouds that count as specks."""

SMALLEST = 10.0
"""Area in pixels below which a cloud has the shape of pixels, not its own (DeWitt and Garrett 2024)."""

_FEWEST = 24
"""Clouds in a bin below which the logarithm of their number is biased (DeWitt and Garrett 2024)."""

_BINS_PER_DECADE = 6
_TRUNCATED = 0.5
_LEAST_BINS = 4
_SHORTEST = 3.0
_DEEPEST = 8


@dataclass(frozen=True)
class Clouds:
    """Clouds of one mask: cloudy pixels that share sides.

    Attributes
    ----------
    area, perimeter : ndarray (N,)
        Pixels, and pixel sides between cloud and clear sky; sides along the frame do not count.
    truncated : ndarray (N,)
        Whether a cloud touches the frame, so that its true size is unknown.
    centre : ndarray (N, 2)
        Mean row and column.
    shape : tuple of int
        Rows and columns of the mask.
    """

    area: Array
    perimeter: Array
    truncated: Mask
    centre: Array
    shape: tuple[int, int]

    @classmethod
    def of(cls, mask: Mask) -> Clouds:
        """Measure the clouds of a mask (rows, columns)."""
        labels, count = label(mask)
        flat = labels.ravel()
        area = np.bincount(flat, minlength=count + 1)[1:].astype(np.float64)
        perimeter = np.zeros(count + 1)
        for one, other in ((labels[1:], labels[:-1]), (labels[:, 1:], labels[:, :-1])):
            differ = (one > 0) != (other > 0)
            perimeter += np.bincount(np.maximum(one[differ], other[differ]), minlength=count + 1)
        truncated = np.zeros(count + 1, dtype=np.bool_)
        for side in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
            truncated[side] = True
        at = np.indices(mask.shape).reshape(2, -1)
        centre = np.stack([np.bincount(flat, along, count + 1)[1:] for along in at], axis=1)
        shape = (mask.shape[0], mask.shape[1])
        return cls(area, perimeter[1:], truncated[1:], centre / np.maximum(area, 1.0)[:, None], shape)


def size_exponent(sizes: Array, truncated: Mask, smallest: float, step: float = 1.0) -> float | None:
    """Return b of the number density n(s) proportional to s^-(1 + b); None if too few clouds for a line.

    Least squares of the logarithm of counts in bins of equal ratio, from ``smallest`` up to the first of three bins in
    a row of which the frame cuts more than half: large clouds are cut more often, and a cut cloud counts as a smaller
    one (T. D. DeWitt and T. J. Garrett, Atmos. Chem. Phys. 24, 8457, 2024). Bins with fewer than 24 clouds are left
    out.

    Parameters
    ----------
    sizes : ndarray (N,)
        Areas or perimeters of all frames.
    truncated : ndarray (N,)
        Whether a cloud touches the frame.
    smallest : float
        In the unit of the sizes.
    step : float
        Difference of possible sizes: 1 for areas in pixels, 2 for perimeters, which are even.
    """
    kept = sizes >= smallest
    bins = np.floor(_BINS_PER_DECADE * np.log10(sizes[kept] / smallest)).astype(np.intp)
    if not bins.size:
        return None
    count = np.bincount(bins)
    cut = np.bincount(bins, truncated[kept], len(count)) > _TRUNCATED * np.maximum(count, 1)
    # One bin may be cut by chance.
    run = np.flatnonzero(cut[2:] & cut[1:-1] & cut[:-2])
    count = count[: run[0]] if run.size else count
    good = np.flatnonzero(count >= _FEWEST)
    if good.size < _LEAST_BINS:
        return None
    # Narrow bins hold few possible sizes: those of a bin are counted, not its width.
    edges = smallest * 10.0 ** (np.arange(count.size + 1) / _BINS_PER_DECADE)
    possible = np.diff(np.ceil(edges / step - 1e-9))[good]
    middle = np.sqrt((edges[:-1] * edges[1:])[good])
    return float(-np.polyfit(np.log(middle), np.log(count[good] / possible), 1)[0] - 1.0)


def individual_dimension(masks: Sequence[Mask]) -> float | None:
    """Return D of perimeter proportional to area^(D/2), holes filled; None if too few clouds (Lovejoy 1982).

    Clouds that touch the frame are left out, because their outlines are straight there. Least squares of the mean
    logarithm of perimeters in bins of equal ratio of the square root of area, from 3 pixels.
    """
    found = [Clouds.of(binary_fill_holes(mask)) for mask in masks]
    length = np.concatenate([np.sqrt(clouds.area[~clouds.truncated]) for clouds in found])
    perimeter = np.concatenate([clouds.perimeter[~clouds.truncated] for clouds in found])
    kept = length >= _SHORTEST
    bins = np.floor(2 * _BINS_PER_DECADE * np.log10(length[kept] / _SHORTEST)).astype(np.intp)
    if not bins.size:
        return None
    count = np.bincount(bins)
    some = np.flatnonzero(count >= 3)
    if some.size < _LEAST_BINS:
        return None
    means = [(np.bincount(bins, np.log(values[kept])) / np.maximum(count, 1))[some] for values in (length, perimeter)]
    return float(np.polyfit(means[0], means[1], 1)[0])


def ensemble_dimension(masks: Sequence[Mask]) -> float | None:
    """Return the box-counting dimension of all outlines together; None without outlines or for small frames.

    Boxes of about 4, 8, ... pixels, up to a quarter of the shorter side, counted over all frames.
    """
    counts = [np.array(boundary_boxes(mask)[1:]) for mask in masks]
    shortest = min((len(found) for found in counts), default=0)
    if shortest < 3:
        return None
    sides, boxes = np.sum([found[:shortest] for found in counts], axis=0).T
    return None if boxes.min() == 0 else float(-np.polyfit(np.log(sides), np.log(boxes), 1)[0])


def organisation(frames: Sequence[Clouds]) -> float | None:
    """Return Iorg: .5 for clouds placed at random, more for clusters, less for even spacing; None below 10 clouds.

    It is the area below the distribution of distances to the nearest neighbour over that of a random field with as many
    clouds (A. M. Tompkins and A. G. Semie, J. Adv. Model. Earth Syst. 9, 1046, 2017). Frames are not periodic: a
    neighbour beyond the frame may be nearer than the one found, so that distances count up to the frame only (the
    estimator of Kaplan and Meier; A. Baddeley and R. D. Gill, Ann. Stat. 25, 263, 1997).
    """
    found: list[Array] = []
    for clouds in frames:
        count = len(clouds.area)
        if count < 2:
            continue
        nearest = cKDTree(clouds.centre).query(clouds.centre, k=2)[0][:, 1]
        last = np.array(clouds.shape) - 1.0
        edge = np.minimum(clouds.centre, last - clouds.centre).min(axis=1) + 0.5
        # The other clouds are those of which one may be near.
        density = (count - 1) / math.prod(clouds.shape)
        found.append(1.0 - np.exp(-density * math.pi * np.stack([nearest, edge]) ** 2))
    if not found or sum(pairs.shape[1] for pairs in found) < 10:
        return None
    # Random distances are uniform on this scale, in frames of any density.
    nearest, edge = np.concatenate(found, axis=1)
    seen, at = nearest <= edge, np.minimum(nearest, edge)
    order = np.lexsort((~seen, at))
    at, seen = at[order], seen[order]
    beyond = np.cumprod(1.0 - seen / np.arange(len(at), 0, -1.0))
    steps = np.diff(np.concatenate(([0.0], at, [1.0])))
    return float(1.0 - np.sum(steps * np.concatenate(([1.0], beyond))))


def edge_profile(masks: Sequence[Mask], contrasts: Sequence[Array]) -> tuple[Array, Array]:
    """Return mean distance from the edge (pixels) and mean contrast of cloudy pixels 1, 2, ... 8 pixels inside of it.

    Edges lie half a pixel before the nearest clear pixel; beyond the frame nothing is clear. NaN where there are none.
    """
    count, distance, total = np.zeros((3, _DEEPEST + 1))
    for mask, contrast in zip(masks, contrasts, strict=True):
        if mask.all():
            continue
        depth = distance_transform_edt(mask)
        inside = (depth > 0.5) & (depth < _DEEPEST + 0.5)
        bins = np.rint(depth[inside]).astype(np.intp)
        count += np.bincount(bins, minlength=_DEEPEST + 1)
        distance += np.bincount(bins, depth[inside] - 0.5, _DEEPEST + 1)
        total += np.bincount(bins, contrast[inside], _DEEPEST + 1)
    some = np.where(count > 0, count, np.nan)
    return (distance / some)[1:], (total / some)[1:]


def edge_exponent(masks: Sequence[Mask], contrasts: Sequence[Array]) -> float | None:
    """Return h of the mean contrast inside edges proportional to distance^h: 0 for plateaus, 1 for even slopes.

    None without clouds 8 pixels deep.
    """
    distance, profile = edge_profile(masks, contrasts)
    return float(np.polyfit(np.log(distance), np.log(profile), 1)[0]) if np.all(profile > 0.0) else None
