"""Parameters whose expected variogram is the measured one: no simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from hcss_twin.clouds.expected_variogram import KernelCorrelation, expected_variogram, frame_variance
from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.errors import ImageError
from hcss_twin.matching.bounds import BRIGHTNESS_EXPONENT, HURST, cells_per_frame, reference_cells
from hcss_twin.matching.cloud_image import CloudImage
from hcss_twin.matching.structure import Structure

Array = NDArray[np.float64]

# The paper: "values of 2, 3, or 4 suffice to meet human visual perception".
GAMMAS = (2.0, 3.0, 4.0)
_MOST_OCTAVES = 12

# Lags of 1 and 2 pixels decide the fractal dimension and the statistics of neighbours.
_WEIGHT_OF_SHORT_LAGS = 2.0

# A fit with fewer octaves is preferred if its misfit is at most this much greater.
_TOLERANCE = 1.02


@dataclass(frozen=True)
class Start:
    """Where the simulations start.

    Attributes
    ----------
    parameters : FractalParameters
        Complete.
    misfit : float
        Root mean square of ln(expected / inferred) over lags and axes, the shortest lags counted more.
    """

    parameters: FractalParameters
    misfit: float


def fit_variogram(underlying: Structure, image: CloudImage) -> Start:
    """Fit gamma, H, L and kmax to the variogram of the field under an image.

    The normal scores of a frame have unit variance in the frame; the field has less there, where
    its cells are large (:func:`frame_variance`). The expected variogram is divided by that.

    Parameters
    ----------
    underlying : Structure
        From :func:`hcss_twin.matching.structure.underlying_structure`.
    image : CloudImage
        Its size and pixels.

    Raises
    ------
    ImageError
        If nothing fits at all.
    """
    kernel = KernelCorrelation.tabulate()
    rows, columns = image.level.shape
    lags, nothing = underlying.lags, np.zeros_like(underlying.lags)
    dx, dy = np.concatenate([lags, nothing]), np.concatenate([nothing, lags])
    wanted = underlying.logarithm
    weight = np.where(dx + dy <= 2, _WEIGHT_OF_SHORT_LAGS, 1.0)

    def residuals(unknowns: Array, gamma: float, last: int) -> Array:
        shape = _parameters(unknowns, gamma, last, image)
        expected = expected_variogram(shape, image.pixel_size_m, dx, dy, kernel)
        variance = frame_variance(shape, image.pixel_size_m, rows, columns, kernel)
        return weight * (np.log(expected / variance) - wanted)

    longest, most = cells_per_frame(image)
    low = np.array([HURST[0], *np.log(longest)])
    high = np.array([HURST[1], *np.log(most)])
    fits: list[Start] = []
    for gamma in GAMMAS:
        unknowns = np.array([0.5, *np.clip(math.log(4.0), low[1:], high[1:])])
        # Octaves with more cells than pixels are white noise, of which one is enough.
        useful = math.ceil(math.log(max(rows, columns)) / math.log(gamma)) + 1
        for last in range(min(_MOST_OCTAVES, useful) + 1):
            found = least_squares(
                residuals, unknowns, bounds=(low, high), args=(gamma, last), xtol=1e-4, ftol=1e-4, max_nfev=60
            )
            if np.all(np.isfinite(found.fun)):
                misfit = float(np.sqrt(np.mean(found.fun**2) / np.mean(weight**2)))
                fits.append(Start(_parameters(found.x, gamma, last, image), misfit))
    if not fits:
        raise ImageError("image: no fractal field has a variogram like it")
    best = min(fit.misfit for fit in fits)
    good = [fit for fit in fits if fit.misfit <= _TOLERANCE * best]
    return min(good, key=lambda fit: (fit.parameters.k or (0, 0))[1])


def brightness_exponent(image: CloudImage) -> float:
    """Return the exponent s that is likeliest if scaled grey levels are C = p^s with uniform p.

    Then -ln C is exponentially distributed with the mean s, and its mean is the estimate. It starts
    the search: within one frame p is not quite uniform.
    """
    # Half a level, so that the thinnest pixel has a logarithm.
    scaled = (image.level[image.cloudy].astype(np.float64) - 0.5) / 254.5
    return float(np.clip(-np.mean(np.log(scaled)), *BRIGHTNESS_EXPONENT))


def _parameters(unknowns: Array, gamma: float, last: int, image: CloudImage) -> FractalParameters:
    hurst, *cells = (float(value) for value in unknowns)
    return FractalParameters(gamma=gamma, H=hurst, L=reference_cells(np.exp(cells), image), k=(0, last))
