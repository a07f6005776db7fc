"""Cloud thickness at the pixels of an image: above a threshold (HCSS paper, eq 7), or by brightness temperature."""

from __future__ import annotations

from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.models.clouds.imagery.cloudiness import TOP_PERCENTILE, Cloudiness, Method
from hcss_twin.models.clouds.imagery.image import COLD_K, SatelliteImage
from hcss_twin.models.clouds.imagery.parameters import ImageryParameters
from hcss_twin.providers import CloudInputs


def method_of(image: SatelliteImage, cloud_is: SatelliteImage.CloudIs) -> Literal["temperature", "otsu"]:
    """Return the method "auto" for an image: no threshold where the image is a brightness temperature."""
    return "temperature" if image.is_temperature and not image.cloud_is_bright(cloud_is) else "otsu"


def thickness_by_threshold(
    image: SatelliteImage, level: Array, scene: tuple[slice, slice], inputs: CloudInputs, parameters: ImageryParameters
) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Return thickness where the level exceeds a threshold, and notes."""
    layer = inputs.layer
    if parameters.limits_um is not None:
        message = "given for an image without kelvin, in which cloud is found by a threshold; allowed: leave it out"
        raise ScenarioError([Problem("clouds.parameters.limits_um", message)], origin="imagery clouds")
    # With an unbounded sky, the coverage refers to the image, not to the part that one sensor sees.
    scope = level if layer.coverage_mode == "field" else level[scene]
    try:
        threshold, lowest = Cloudiness.threshold(
            level, cast(Method, parameters.method), parameters.window_pixels, layer.coverage, scope
        )
    except ValueError as error:
        raise ScenarioError([Problem("clouds.coverage", str(error))], origin="imagery clouds") from error
    cloudy = level > threshold
    thickness = np.zeros(level.shape, dtype=np.float32)
    thickness[cloudy] = Cloudiness.thickness_of(
        Cloudiness.relative_grey(level[cloudy], lowest), layer.thickness_min_m, layer.thickness_max_m
    )
    if parameters.method == "coverage":
        where = "over the whole image" if layer.coverage_mode == "field" else "there"
        coverage = f"; {layer.coverage:g} was requested {where}. Later frames show other parts of the image."
    else:
        coverage = (
            f", as found in the image by the method '{parameters.method}'; "
            f"the scenario's coverage, {layer.coverage:g}, is not used."
        )
    notes = (
        coverage,
        f"Thickness is linear in the grey level up to the {TOP_PERCENTILE:g}th percentile of the "
        "cloudy pixels of the whole image; what is brighter has the greatest thickness. Shapes do not "
        "change.",
        *image.lost_cloud(level, cloudy, parameters.cloud_is),
    )
    return thickness, notes


def thickness_by_temperature(
    image: SatelliteImage, level: Array, scene: tuple[slice, slice], inputs: CloudInputs, parameters: ImageryParameters
) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Return the thickness with which the scene has the image's brightness temperature, and notes."""
    layer, inversion = inputs.layer, inputs.inversion
    if not image.is_temperature or image.cloud_is_bright(parameters.cloud_is):
        given = f"unit '{image.units}'" if not image.is_temperature else f"cloud_is '{parameters.cloud_is}'"
        message = (
            f"'temperature' given for an image with {given}; allowed: brightness temperature in kelvin where cloud is "
            "cold; closest is the method 'otsu'"
        )
        raise ScenarioError([Problem("clouds.parameters.method", message)], origin="imagery clouds")
    if inversion is None:  # outside a scene: the linear law of eq 7, from the warmest pixel
        outside, known = np.zeros(level.shape, dtype=np.float32), ~np.isnan(level)
        relative = Cloudiness.relative_grey(level[known], float(np.min(level[known])))
        outside[known] = Cloudiness.thickness_of(relative, layer.thickness_min_m, layer.thickness_max_m)
        return outside, (" (no scene: linear in temperature)",)
    band = "10.8 um"
    if parameters.limits_um is not None:
        inversion = inversion.in_band(parameters.limits_um)
        band = f"{parameters.limits_um[0]:g} to {parameters.limits_um[1]:g} um, without sunlight"
    elif image.wavelength_um is not None:
        _require_window(image.wavelength_um)
    kelvin = -level
    thickness = inversion.thickness_m(kelvin)
    cold = kelvin[scene] < inversion.clear_K - COLD_K
    lost = np.count_nonzero(cold & (thickness[scene] == 0.0)) / cold.size
    colder = np.count_nonzero(kelvin[scene] < inversion.coldest_K - COLD_K) / cold.size
    warmer = np.count_nonzero(kelvin[scene] > inversion.clear_K + COLD_K) / cold.size
    notes = (
        f"; the scenario's coverage, {layer.coverage:g}, is not used.",
        f"Each pixel has the thickness with which the scene has the image's brightness temperature at {band}, from "
        f"{inversion.clear_K:.5g} K (clear sky) to {inversion.coldest_K:.5g} K. {lost:.2%} of the scene's pixels are "
        f"{COLD_K:g} K colder than clear sky and too thin for the layer, {colder:.2%} are {COLD_K:g} K colder than its "
        f"thickest cloud, {warmer:.2%} are {COLD_K:g} K warmer than clear sky. Shapes do not change.",
    )
    return thickness, notes


def _require_window(wavelength_um: float) -> None:
    """Reject an image whose file states a band far from 10.8 um, in which temperatures would be taken for others."""
    low, high = SatelliteImage.WINDOW_UM
    if not low <= wavelength_um <= high:
        message = (
            f"none given, and the image's band is at {wavelength_um:g} um; allowed: none for {low:g} to "
            f"{high:g} um only; closest is about [{0.975 * wavelength_um:.3g}, {1.025 * wavelength_um:.3g}]"
        )
        raise ScenarioError([Problem("clouds.parameters.limits_um", message)], origin="imagery clouds")
