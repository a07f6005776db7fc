"""Segmentation of a mask of cloudy pixels into single clouds: closing, opening, holes, small clouds, labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

# Cloudy pixels are 8-connected (edges and corners), clear ones 4-connected (edges only): with this pair, a closed curve
# of one class always separates the pixels of the other.
_CLOUD = np.ones((3, 3), dtype=np.bool_)
_CLEAR = ndimage.generate_binary_structure(2, 1)


@dataclass(frozen=True)
class Cleaning:
    """Parameters, in pixels, for cleaning a thresholded mask. By default it stays that of the image.

    Attributes
    ----------
    closing, opening : int
        Odd diameter of the disc; 1 changes nothing.
    largest_hole : int
        Holes of up to this many pixels are filled; 0 fills none.
    min_area : int
        Area of the smallest cloud that is retained.
    """

    closing: int = 1
    opening: int = 1
    largest_hole: int = 0
    min_area: int = 1

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
        0 for clear or missing, 1 to ``clouds`` in the order of their first pixels.
    clouds, holes, hole_pixels, dropped : int
        Numbers of clouds, filled holes, pixels in filled holes, and clouds dropped as too small.
    """

    labels: NDArray[np.int32]
    clouds: int
    holes: int
    hole_pixels: int
    dropped: int


def disc(diameter: int) -> NDArray[np.bool_]:
    """Return the pixels whose centres are within a circle of odd ``diameter``: 3 is a square, 5 is not."""
    offset = np.arange(diameter) - diameter // 2
    within: NDArray[np.bool_] = offset[:, None] ** 2 + offset[None, :] ** 2 <= (diameter / 2.0) ** 2
    return within


def closed(mask: NDArray[np.bool_], diameter: int) -> NDArray[np.bool_]:
    """Return the closing of ``mask`` by a disc; it contains the mask, also at the image border."""
    grown = ndimage.binary_dilation(mask, disc(diameter))
    result: NDArray[np.bool_] = ndimage.binary_erosion(grown, disc(diameter), border_value=1)
    return result


def opened(mask: NDArray[np.bool_], diameter: int) -> NDArray[np.bool_]:
    """Return the opening of ``mask`` by a disc; the mask contains it.

    Pixels outside the image count as cloud, so that the opening does not erode clouds at the border.
    """
    shrunk = ndimage.binary_erosion(mask, disc(diameter), border_value=1)
    result: NDArray[np.bool_] = ndimage.binary_dilation(shrunk, disc(diameter))
    return result


def small_holes(mask: NDArray[np.bool_], missing: NDArray[np.bool_], largest: int) -> tuple[NDArray[np.bool_], int]:
    """Return the pixels (rows, columns) of holes of up to ``largest`` pixels, and the number of these holes.

    A hole is clear sky enclosed by cloud. Clear sky that touches the image border may continue outside, and the extent
    of clear sky with a missing pixel is unknown; neither is a hole.
    """
    labels, count = ndimage.label(~mask, _CLEAR)
    is_hole = np.bincount(labels.ravel(), minlength=count + 1) <= largest
    is_hole[labels[missing]] = False
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        is_hole[edge] = False
    is_hole[0] = False  # label 0 is cloud
    return is_hole[labels], int(np.count_nonzero(is_hole))


def segment(cloudy: NDArray[np.bool_], missing: NDArray[np.bool_], cleaning: Cleaning | None = None) -> Segmentation:
    """Clean a mask and number its clouds.

    Steps: closing (joins clouds across gaps narrower than the disc), opening (removes structures narrower
    than the disc), filling of small holes, removal of small clouds, labelling. Cloudy pixels that share an edge or a
    corner belong to the same cloud. Missing pixels never become cloud.

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
    large = np.bincount(labels.ravel(), minlength=count + 1) >= cleaning.min_area
    large[0] = False
    numbers = np.where(large, np.cumsum(large), 0).astype(np.int32)
    clouds = int(np.count_nonzero(large))
    return Segmentation(numbers[labels], clouds, holes, int(np.count_nonzero(filled)), count - clouds)
