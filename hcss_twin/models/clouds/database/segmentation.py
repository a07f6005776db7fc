"""From a mask of cloudy pixels to single clouds: closing, opening, holes, small clouds, labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

# Clouds hang together over edges and corners, clear sky over edges only: the pair of connectivities for
# which a closed curve of one always separates the other.
_CLOUD = np.ones((3, 3), dtype=np.bool_)
_CLEAR = ndimage.generate_binary_structure(2, 1)


@dataclass(frozen=True)
class Cleaning:
    """How a thresholded mask is cleaned; sizes are in pixels.

    Attributes
    ----------
    closing, opening : int
        Diameter of the disc, odd; 1 does nothing.
    largest_hole : int
        Holes of up to this many pixels are filled; 0 fills none.
    min_area : int
        Smallest cloud that is kept.
    """

    closing: int = 3
    opening: int = 1
    largest_hole: int = 100
    min_area: int = 9

    def __post_init__(self) -> None:
        for name in ("closing", "opening"):
            value = getattr(self, name)
            if value < 1 or value % 2 == 0:
                raise ValueError(
                    f"{name}: {value} given, allowed: an odd diameter of 1 or more; closest is {max(1, value + 1)}"
                )
        for name, lowest in (("largest_hole", 0), ("min_area", 1)):
            if getattr(self, name) < lowest:
                raise ValueError(f"{name}: {getattr(self, name)} given, allowed: {lowest} or more; closest is {lowest}")


@dataclass(frozen=True)
class Segmentation:
    """Single clouds of an image.

    Attributes
    ----------
    labels : ndarray of int32 (rows, columns)
        0 clear or missing, 1 to ``clouds`` in the order of their first pixels.
    clouds : int
        Number of clouds.
    holes, hole_pixels : int
        Holes that were filled, and their pixels.
    dropped : int
        Clouds that were too small.
    """

    labels: NDArray[np.int32]
    clouds: int
    holes: int
    hole_pixels: int
    dropped: int


def disc(diameter: int) -> NDArray[np.bool_]:
    """Return the pixels whose centres lie within a circle of odd ``diameter``: 3 is a square, 5 is not."""
    offset = np.arange(diameter) - diameter // 2
    within: NDArray[np.bool_] = offset[:, None] ** 2 + offset[None, :] ** 2 <= (diameter / 2.0) ** 2
    return within


def closed(mask: NDArray[np.bool_], diameter: int) -> NDArray[np.bool_]:
    """Return the closing of ``mask`` by a disc; never less than the mask, at the image's border too."""
    grown = ndimage.binary_dilation(mask, disc(diameter))
    result: NDArray[np.bool_] = ndimage.binary_erosion(grown, disc(diameter), border_value=1)
    return result


def opened(mask: NDArray[np.bool_], diameter: int) -> NDArray[np.bool_]:
    """Return the opening of ``mask`` by a disc; never more than the mask.

    What lies outside the image counts as cloud, so that clouds that it cuts are not worn away there.
    """
    shrunk = ndimage.binary_erosion(mask, disc(diameter), border_value=1)
    result: NDArray[np.bool_] = ndimage.binary_dilation(shrunk, disc(diameter))
    return result


def small_holes(mask: NDArray[np.bool_], missing: NDArray[np.bool_], largest: int) -> tuple[NDArray[np.bool_], int]:
    """Return the pixels of holes of up to ``largest`` pixels, and how many holes they are.

    A hole is a part of clear sky that cloud encloses. What touches the border of the image may go on
    outside, and what holds a missing pixel is not known: neither is a hole.
    """
    labels, count = ndimage.label(~mask, _CLEAR)
    is_hole = np.bincount(labels.ravel(), minlength=count + 1) <= largest
    is_hole[labels[missing]] = False
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        is_hole[edge] = False
    is_hole[0] = False  # the cloud
    return is_hole[labels], int(np.count_nonzero(is_hole))


def segment(cloudy: NDArray[np.bool_], missing: NDArray[np.bool_], cleaning: Cleaning | None = None) -> Segmentation:
    """Clean a mask and number its clouds.

    In this order: closing (joins what gaps of less than the disc part), opening (removes what is
    narrower than the disc), filling of small holes, removal of small clouds, labelling. Two cloudy
    pixels that share an edge or a corner belong to one cloud. Missing pixels are never made cloud.

    Parameters
    ----------
    cloudy, missing : ndarray of bool (rows, columns)
        Thresholded mask, and where the image has no value.
    cleaning : Cleaning, optional
        Sizes.
    """
    cleaning = cleaning or Cleaning()
    mask = cloudy & ~missing
    if cleaning.closing > 1:
        mask = closed(mask, cleaning.closing) & ~missing
    if cleaning.opening > 1:
        mask = opened(mask, cleaning.opening)
    filled, holes = small_holes(mask, missing, cleaning.largest_hole)
    mask = mask | filled
    labels, count = ndimage.label(mask, _CLOUD)
    kept = np.bincount(labels.ravel(), minlength=count + 1) >= cleaning.min_area
    kept[0] = False
    numbers = np.where(kept, np.cumsum(kept), 0).astype(np.int32)
    numbered = numbers[labels]
    return Segmentation(
        labels=numbered,
        clouds=int(np.count_nonzero(kept)),
        holes=holes,
        hole_pixels=int(np.count_nonzero(filled)),
        dropped=count - int(np.count_nonzero(kept)),
    )
