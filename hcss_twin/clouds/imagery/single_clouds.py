"""The single clouds of a database entry, as shapes that can be put anywhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from hcss_twin.clouds.database.entry import CloudEntry
from hcss_twin.clouds.imagery.grey_levels import thickness_of
from hcss_twin.errors import CatalogError, Problem, ScenarioError


@dataclass(frozen=True)
class SingleClouds:
    """Shapes in one array: cloud c fills ``heights[c]`` x ``widths[c]`` values from ``starts[c]`` on, by rows.

    Attributes
    ----------
    thickness_m : ndarray of float32 (N,)
        Thickness in the rectangles around the clouds, rows northward; 0 outside the cloud.
    starts, heights, widths, areas : ndarray of int64 (clouds,)
        Place in ``thickness_m``, sides of the rectangle, and cloudy pixels.
    left_out : int
        Clouds of the entry that are not among them.
    """

    thickness_m: NDArray[np.float32]
    starts: NDArray[np.int64]
    heights: NDArray[np.int64]
    widths: NDArray[np.int64]
    areas: NDArray[np.int64]
    left_out: int

    @property
    def mean_area(self) -> float:
        """Mean number of cloudy pixels."""
        return float(np.mean(self.areas))

    @property
    def largest_side(self) -> int:
        """Longest side of any rectangle."""
        return int(max(self.heights.max(), self.widths.max()))


def single_clouds(
    entry: CloudEntry,
    thickness_min_m: float,
    thickness_max_m: float,
    pixels: tuple[int, int] | None = None,
) -> SingleClouds:
    """Take the whole clouds of an entry, those of an area within ``pixels`` where it is given.

    Clouds that the border of the image or missing pixels cut are left out: their outline there is
    not that of a cloud.

    Raises
    ------
    CatalogError
        If the border cut all clouds.
    ScenarioError
        If none has the size asked for.
    """
    labels, grey, missing = entry.labels[::-1], entry.grey[::-1], entry.missing[::-1]
    cut = np.zeros(entry.facts.clouds + 1, dtype=np.bool_)
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        cut[edge] = True
    cut[labels[ndimage.binary_dilation(missing, np.ones((3, 3)))]] = True
    shapes, sides, areas = [], [], []
    for number, where in enumerate(ndimage.find_objects(labels), start=1):
        if cut[number]:
            continue
        cloudy = labels[where] == number
        area = int(np.count_nonzero(cloudy))
        if pixels is not None and not pixels[0] <= area <= pixels[1]:
            continue
        shape = np.zeros(cloudy.shape, dtype=np.float32)
        relative = (grey[where][cloudy].astype(np.float64) - 1.0) / 254.0
        shape[cloudy] = thickness_of(relative, thickness_min_m, thickness_max_m)
        shapes.append(shape.ravel())
        sides.append(shape.shape)
        areas.append(area)
    if not shapes:
        whole = np.bincount(labels.ravel(), minlength=cut.size)[1:][~cut[1:]]
        if whole.size:
            low, high = int(whole.min()), int(whole.max())
            message = (
                f"{list(pixels or ())} given; allowed: a range that meets {low} to {high}, the sizes of the "
            )
            raise ScenarioError(
                [
                    Problem(
                        "clouds.parameters.cloud_pixels",
                        f"{message}entry's whole clouds; closest is [{low}, {high}]",
                    )
                ],
                origin="imagery clouds",
            )
        raise CatalogError(
            f"the border of the image or missing pixels cut all {entry.facts.clouds} clouds of the entry; allowed: "
            'placement = "scene", or an image with whole clouds'
        )
    sizes = np.array([shape.size for shape in shapes], dtype=np.int64)
    heights, widths = np.array(sides, dtype=np.int64).T
    return SingleClouds(
        thickness_m=np.concatenate(shapes),
        starts=np.cumsum(sizes) - sizes,
        heights=np.ascontiguousarray(heights),
        widths=np.ascontiguousarray(widths),
        areas=np.array(areas, dtype=np.int64),
        left_out=entry.facts.clouds - len(shapes),
    )
