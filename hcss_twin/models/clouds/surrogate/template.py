"""What a surrogate imitates: the cloud thickness that the imagery generator finds in part of an image."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.imagery.generator import ImageryClouds
from hcss_twin.models.clouds.imagery.parameters import ImageReading, ImageryParameters
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.clouds.imagery.whole_scene import size_notes
from hcss_twin.models.clouds.surrogate.parameters import SurrogateParameters
from hcss_twin.providers import CloudInputs, Grid, Motion

# A crop as small as a tiny scene would have no spectrum to speak of.
_SMALLEST_CROP = 64


@dataclass(frozen=True)
class Template:
    """Cloud thickness of a part of an image.

    Attributes
    ----------
    thickness_m : ndarray of float32 (rows, columns)
        0 where clear; rows northward, columns eastward.
    notes : tuple of str
        What users should know about the image.
    """

    thickness_m: NDArray[np.float32]
    notes: tuple[str, ...]

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return float(np.count_nonzero(self.thickness_m)) / self.thickness_m.size

    def amplitudes(self, count: int, coverage: float) -> NDArray[np.float32]:
        """Return ``count`` thicknesses, ascending, with the distribution of the template.

        Parameters
        ----------
        count : int
            Number of pixels.
        coverage : float
            Fraction of cloudy ones, held to half a pixel. Each of them is an existing thickness, the middle
            of its share of the template's cloudy pixels: with the template's count and coverage the result
            is the template's pixels.

        Raises
        ------
        ScenarioError
            If there must be cloudy pixels and the template has none.
        """
        ascending = np.sort(self.thickness_m, axis=None)
        cloudy = ascending[ascending.size - np.count_nonzero(ascending) :]
        wanted = round(coverage * count)
        if wanted and not cloudy.size:
            message = (
                f"{coverage:g} given, but at that coverage no pixel of the crop is cloudy; "
                "allowed: a greater one, a larger crop, or an image with finer grey levels"
            )
            raise ScenarioError([Problem("clouds.coverage", message)], origin="surrogate clouds")
        result = np.zeros(count, dtype=np.float32)
        if wanted:
            result[count - wanted :] = cloudy[(2 * np.arange(wanted, dtype=np.int64) + 1) * cloudy.size // (2 * wanted)]
        return result


def read_template(inputs: CloudInputs, parameters: SurrogateParameters) -> Template:
    """Read the image and cut the template out of it, as :class:`ImageryClouds` does.

    Raises
    ------
    CatalogError
        If the file is missing or not a usable image.
    ScenarioError
        If the crop does not fit the image, pixel sizes differ, or pixels are missing.
    """
    image = read_image(inputs.catalog.file(parameters.image), parameters.variable)
    whole = image.values.shape
    crop = []
    problems = []
    for axis, of_scene, of_image in zip(
        ("rows", "columns"), (inputs.grid.rows, inputs.grid.columns), whole, strict=True
    ):
        given = getattr(parameters, f"crop_{axis}")
        crop.append(min(max(of_scene, _SMALLEST_CROP), of_image) if given is None else given)
        if given is not None and given > of_image:
            problems.append(
                Problem(
                    f"clouds.parameters.crop_{axis}",
                    f"{given} is more than the image has ({whole[0]} rows, {whole[1]} columns); closest is {of_image}",
                )
            )
    if problems:
        raise ScenarioError(problems, origin="surrogate clouds")
    still = dataclasses.replace(
        inputs,
        layer=dataclasses.replace(inputs.layer, coverage_mode="frame"),
        grid=Grid(crop[0], crop[1], inputs.grid.pixel_size_m),
        motion=Motion(0.0, (0.0, 0.0), math.inf, 0.0),
    )
    cut = {name: getattr(parameters, name) for name in ImageReading.model_fields}
    clouds = ImageryClouds(still, ImageryParameters(image=parameters.image, **cut))
    thickness = clouds.thickness_m(0.0, slice(None), slice(None))
    return Template(thickness, tuple(size_notes(image.pixel_size_m, image.pixel_size_is_nominal, inputs)))
