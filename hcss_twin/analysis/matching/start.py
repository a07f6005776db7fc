"""Limits of the search, and lattice cells per frame instead of per 16 km.

Parameters whose expected variogram is the measured one: no simulation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from hcss_twin.analysis.matching.structure import CloudImage, Structure
from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ImageError
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation, expected_variogram, frame_variance
from hcss_twin.models.clouds.fractal.octaves import REFERENCE_LENGTH_M
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

HURST = (0.02, 0.98)
BRIGHTNESS_EXPONENT = (0.1, 10.0)

# With fewer cells across the frame each frame has another mean and another range, and its histogram,
# which eq 5 takes to be that of the whole sky, is anything.
FEWEST_CELLS = 1.0

# Cells of less than two pixels are white noise at k = 0.
_CELLS_PER_PIXEL = 0.5


def cells_per_frame(image: CloudImage) -> tuple[Array, Array]:
    """Return the fewest and the most cells (2,) across the frame, along x and y."""
    rows, columns = image.level.shape
    return np.full(2, FEWEST_CELLS), _CELLS_PER_PIXEL * np.array([columns, rows], dtype=np.float64)


def reference_cells(cells: Array, image: CloudImage) -> tuple[float, float]:
    """Turn cells across the frame (2,) into L, cells per 16 km, along x and y."""
    x, y = np.asarray(cells) * REFERENCE_LENGTH_M / _sides_m(image)
    return float(x), float(y)


def frame_cells(reference: tuple[float, float], image: CloudImage) -> Array:
    """Turn L into cells across the frame (2,), along x and y."""
    cells: Array = np.array(reference) * _sides_m(image) / REFERENCE_LENGTH_M
    return cells


def _sides_m(image: CloudImage) -> Array:
    rows, columns = image.level.shape
    return np.array([columns, rows]) * image.pixel_size_m


# The paper: "values of 2, 3, or 4 suffice to meet human visual perception".
GAMMAS = (2.0, 3.0, 4.0)
_MAX_OCTAVES = 12

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
        From :func:`hcss_twin.analysis.matching.structure.underlying_structure`.
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
        for last in range(min(_MAX_OCTAVES, useful) + 1):
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
