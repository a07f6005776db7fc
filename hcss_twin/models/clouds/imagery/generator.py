"""Clouds from satellite images (section III.A.1 of the HCSS paper): static scenes.

A threshold gives the cloud mask, and grey levels are converted to thickness (eq 7). The clouds are those of the image
scene, or single clouds scattered over an unbounded sky.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.database import FOLDER, SUFFIX
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.models.clouds.imagery.scattered import ScatteredClouds
from hcss_twin.models.clouds.imagery.whole_scene import WholeScene
from hcss_twin.models.clouds.thickness import window_inside
from hcss_twin.providers import CloudDeclaration, CloudInputs


class ImageryClouds:
    """Clouds of a satellite image, with constant shapes.

    They come from an image or from an entry of the cloud database, whose clouds were extracted and inspected
    beforehand. In an image, a pixel is cloudy if its grey level exceeds a threshold
    (:mod:`hcss_twin.models.clouds.imagery.cloudiness`). Thickness is linear in the grey level (eq 7 of the HCSS paper),

    Th = Th_min + (Th_max - Th_min) (C - C_min) / (C_max - C_min),

    with C_min the (lowest) threshold and C_max the 99.9th percentile of the cloudy pixels; brighter pixels have Th_max.
    Both refer to the whole image, so that all frames agree.

    A whole scene starts at ``row_origin``, ``column_origin``, or at the image centre. It moves over the image by whole
    pixels, (v_platform - v_x) t to the east and -v_y t to the north, up to the image border. Scattered clouds move in
    the same way without a border. Rows of the image are flipped so that y grows northward with the row.

    The image should show only clouds and sea: bright land is classified as cloud.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion and the catalog that records the file. The seed is used only for scattered clouds.
    parameters : ImageryParameters
        The image or entry and how it is used.

    Attributes
    ----------
    image_coverage : float or None
        Fraction of cloudy pixels of a whole scene at time 0; None for scattered clouds.

    Raises
    ------
    CatalogError
        If the file is missing or not usable.
    ScenarioError
        If scene and image do not match in size, pixel size, origin, missing pixels or coverage.
    """

    declares: CloudDeclaration
    honours = ("coverage_mode",)

    def __init__(self, inputs: CloudInputs, parameters: ImageryParameters) -> None:
        if inputs.layer.edge_taper != 0.0:
            problem = Problem(
                "clouds.edge_taper",
                f"{inputs.layer.edge_taper:g} given; clouds of an image have the edges of the image; allowed: 0",
            )
            raise ScenarioError([problem], origin="imagery clouds")
        self._grid = inputs.grid
        self._clouds: WholeScene | ScatteredClouds
        if parameters.entry is not None:
            path = inputs.catalog.find(parameters.entry, FOLDER, SUFFIX, beside=True)
        else:
            path = inputs.catalog.file(str(parameters.image))
        kind = ScatteredClouds if parameters.placement == "single-clouds" else WholeScene
        self._clouds = kind(inputs, parameters, path)
        self.declares = self._clouds.declares
        self.image_coverage: float | None = self._clouds.image_coverage

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> NDArray[np.float32]:
        """Return geometric thickness (y, x) in metres of a window at ``time_s``; 0 is clear sky.

        Raises
        ------
        ScenarioError
            If the footprint has left the image or contains missing pixels.
        ValueError
            If the time is not finite or the window is not inside the scene.
        """
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        return self._clouds.thickness_m(time_s, *window_inside(rows, columns, self._grid))
