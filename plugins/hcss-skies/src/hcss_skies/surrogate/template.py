"""Template of the surrogates: amplitudes and spectrum of the cloud thickness in part of an image.

The spectrum is free of border effects and can be computed for a plane of any size.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray
from scipy.fft import fft2, fftfreq, ifft2, irfft2, rfft2, rfftfreq
from scipy.ndimage import map_coordinates
from scipy.special import ndtri

from hcss_skies.surrogate.parameters import SurrogateParameters
from hcss_twin.models.clouds.imagery.parameters import ImageReading
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import Array, CloudInputs, Grid, Kind, Motion, Problem, ScenarioError
from hcss_twin.providers.registry.registry import Registry

# The spectrum of a smaller crop would have too few wavenumbers.
_SMALLEST_CROP = 64

# Numbers of quantiles of an amplitude distribution, terms of its Hermite series, and correlations.
_QUANTILES = 1 << 14
_HERMITE_TERMS = 80
_CORRELATIONS = 1 << 13


@dataclass(frozen=True)
class Template:
    """Cloud thickness in part of an image.

    Attributes
    ----------
    thickness_m : ndarray of float32 (rows, columns)
        0 where clear; rows northward, columns eastward.
    notes : tuple of str
        User notes on the image.
    """

    thickness_m: NDArray[np.float32]
    notes: tuple[str, ...]

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return float(np.count_nonzero(self.thickness_m)) / self.thickness_m.size

    def amplitudes(self, count: int, coverage: float) -> NDArray[np.float32]:
        """Return ``count`` ascending thicknesses with the distribution of the template.

        Parameters
        ----------
        count : int
            Number of pixels.
        coverage : float
            Fraction of cloudy pixels, exact to half a pixel. Thicknesses are mid-quantiles of the template's cloudy
            pixels; with the template's count and coverage, the result equals its pixels.

        Raises
        ------
        ScenarioError
            If cloudy pixels are needed and the template has none.
        """
        ascending = np.sort(self.thickness_m, axis=None)
        cloudy = ascending[ascending.size - np.count_nonzero(ascending) :]
        number = round(coverage * count)
        if number and not cloudy.size:
            message = (
                f"{coverage:g} given, but at that coverage no pixel of the crop is cloudy; "
                "allowed: a greater one, a larger crop, or an image with finer grey levels"
            )
            raise ScenarioError([Problem("clouds.coverage", message)], origin="surrogate clouds")
        result = np.zeros(count, dtype=np.float32)
        if number:
            result[count - number :] = cloudy[(2 * np.arange(number, dtype=np.int64) + 1) * cloudy.size // (2 * number)]
        return result


def read_template(inputs: CloudInputs, parameters: SurrogateParameters) -> Template:
    """Read the image and extract the template, as the generator ``imagery`` extracts a scene.

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
    registry = Registry.defaults_only()
    clouds = registry.create(registry.resolve(Kind.CLOUDS, "imagery"), still, {"image": parameters.image, **cut})
    thickness = clouds.thickness_m(0.0, slice(None), slice(None))
    return Template(thickness, (*image.described(parameters.cloud_is), *image.size_notes(inputs.grid)))


def periodic_component(image: Array) -> Array:
    """Return the periodic component of an image (same shape), without its jumps across opposite borders.

    L. Moisan, "Periodic plus smooth image decomposition", J. Math. Imaging Vis. 39, 161-179 (2011): the smooth
    component solves the discrete Poisson equation with the jump across the borders as source; the remainder has
    (almost) no jump. The plain transform of a non-periodic image shows a cross along both axes, and its surrogates have
    stripes. Mirroring the image would remove the jumps too, but gives oblique streaks the spectrum of a lattice; a
    window would give more weight to the image centre and widen each peak.
    """
    rows, columns = image.shape
    jumps = np.zeros_like(image)
    across = image[-1] - image[0]
    jumps[0] += across
    jumps[-1] -= across
    along = image[:, -1] - image[:, 0]
    jumps[:, 0] += along
    jumps[:, -1] -= along
    # Eigenvalues of the discrete Laplacian on a torus.
    laplacian = (
        2.0 * np.cos(2.0 * np.pi * fftfreq(rows))[:, None] + 2.0 * np.cos(2.0 * np.pi * fftfreq(columns))[None, :] - 4.0
    )
    laplacian[0, 0] = 1.0
    smooth = fft2(jumps) / laplacian
    smooth[0, 0] = 0.0
    component: Array = image - ifft2(smooth).real
    return component


def plane_magnitude(component: Array, shape: tuple[int, int]) -> Array:
    """Return the Fourier magnitudes of a plane with the spectrum of a (periodic) image.

    Parameters
    ----------
    component : ndarray (rows, columns)
        The image.
    shape : (int, int)
        Rows and columns of the plane. If they differ from those of the image, the power is interpolated linearly
        between the wavenumbers of the image: structures larger than the image have no power of their own.

    Returns
    -------
    ndarray (shape[0], shape[1] // 2 + 1)
        Magnitudes of ``rfft2``, 0 at wavenumber 0, for a variance of 1; all 0 for a constant image.
    """
    rows, columns = component.shape
    varying = component - component.mean()
    if shape == component.shape:
        magnitude: Array = np.abs(rfft2(varying))
    else:
        power = np.abs(fft2(varying)) ** 2
        power[0, 0] = 0.0
        y, x = np.meshgrid(fftfreq(shape[0]) * rows, rfftfreq(shape[1]) * columns, indexing="ij")
        magnitude = np.sqrt(map_coordinates(power, (y, x), order=1, mode="grid-wrap"))
    magnitude[0, 0] = 0.0
    variance = float(irfft2(magnitude**2, s=shape)[0, 0]) / (shape[0] * shape[1])
    return magnitude / np.sqrt(variance) if variance > 0.0 else magnitude


def underlying_magnitude(magnitude: Array, shape: tuple[int, int], amplitudes: Array) -> Array:
    """Return the magnitudes of the Gaussian field that has ``magnitude`` after mapping to ``amplitudes``.

    Mapping a Gaussian field X to the amplitudes g(X) changes its correlation r into sum_n c_n^2 r^n / sum_n c_n^2 with
    the Hermite coefficients c_n of g (M. Grigoriu, "Crossings of non-Gaussian translation processes", J. Eng. Mech.
    110, 610-620, 1984), which is inverted here at each lag. The spectrum of X lies between 0 and that of g(X) over
    c_1^2, because no term is negative; where no such X exists, it is clipped to these limits. From this start few
    iterations suffice, and they do not jump between solutions as it changes.

    Parameters
    ----------
    magnitude : ndarray (shape[0], shape[1] // 2 + 1)
        Magnitudes after the mapping, from :func:`plane_magnitude`.
    shape : (int, int)
        Rows and columns of the plane.
    amplitudes : ndarray (N,)
        Amplitudes after the mapping, ascending, not all equal.

    Returns
    -------
    ndarray (shape[0], shape[1] // 2 + 1)
        For a variance of 1. Equal to ``magnitude`` if the amplitudes are normal.
    """
    share = _hermite_shares(amplitudes)
    correlation = np.linspace(-1.0, 1.0, _CORRELATIONS + 1)
    # Increases for any monotonic g, except for rounding.
    mapped = np.maximum.accumulate(polyval(correlation, np.concatenate(([0.0], share))))
    power = magnitude**2
    covariance = irfft2(power, s=shape)
    underlying = rfft2(np.interp(covariance / covariance[0, 0], mapped, correlation)).real
    clipped = np.clip(underlying, 0.0, power / (covariance[0, 0] * share[0]))
    clipped[0, 0] = 0.0
    variance = float(irfft2(clipped, s=shape)[0, 0]) / (shape[0] * shape[1])
    result: Array = np.sqrt(clipped / variance)
    return result


def _hermite_shares(amplitudes: Array) -> Array:
    """Return the normalised c_n^2, n = 1, 2, ..., of the map from normal quantiles to ``amplitudes``."""
    level = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
    normal = ndtri(level)
    values = amplitudes[(level * amplitudes.size).astype(np.int64)]
    values = values - values.mean()
    squares = np.empty(_HERMITE_TERMS)
    before, polynomial = np.ones_like(normal), normal.copy()
    for n in range(1, _HERMITE_TERMS + 1):
        squares[n - 1] = np.mean(values * polynomial) ** 2
        # Normalised: He_(n+1) / sqrt((n+1)!).
        before, polynomial = (polynomial, (normal * polynomial - np.sqrt(n) * before) / np.sqrt(n + 1.0))
    shares: Array = squares / squares.sum()
    return shares
