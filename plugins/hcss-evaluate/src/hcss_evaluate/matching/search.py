"""Parameter search: an analytic start from the expected variogram, and a refinement by simulations.

The search uses lattice cells per frame; the parameters use cells per 16 km.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, minimize

from hcss_evaluate.matching.structure import CloudImage, Structure, image_structure, mean_structure, simulate_image
from hcss_evaluate.measures.morphology import morphology_errors
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, ImageError

HURST = (0.02, 0.98)
BRIGHTNESS_EXPONENT = (0.1, 10.0)

# With fewer cells, mean and range vary from frame to frame, and a frame's histogram does not represent that of the
# whole sky, as eq 5 assumes.
FEWEST_CELLS = 1.0

# Cells of less than two pixels are white noise at k = 0.
_CELLS_PER_PIXEL = 0.5


def cells_per_frame(image: CloudImage) -> tuple[Array, Array]:
    """Return the fewest and the most cells (2,) across the frame, along x and y."""
    rows, columns = image.level.shape
    return np.full(2, FEWEST_CELLS), _CELLS_PER_PIXEL * np.array([columns, rows], dtype=np.float64)


def reference_cells(cells: Array, image: CloudImage) -> tuple[float, float]:
    """Convert cells across the frame (2,) to L, cells per 16 km, along x and y."""
    x, y = np.asarray(cells) * Octave.REFERENCE_LENGTH_M / _sides_m(image)
    return float(x), float(y)


def frame_cells(reference: tuple[float, float], image: CloudImage) -> Array:
    """Convert L to cells across the frame (2,), along x and y."""
    cells: Array = np.array(reference) * _sides_m(image) / Octave.REFERENCE_LENGTH_M
    return cells


def _sides_m(image: CloudImage) -> Array:
    rows, columns = image.level.shape
    return np.array([columns, rows]) * image.pixel_size_m


# The paper: "values of 2, 3, or 4 suffice to meet human visual perception".
GAMMAS = (2.0, 3.0, 4.0)
_MAX_OCTAVES = 12

# Lags of 1 and 2 pixels determine the fractal dimension and the statistics of neighbours.
_WEIGHT_OF_SHORT_LAGS = 2.0

# A fit with fewer octaves is preferred if its misfit is at most this much greater.
_TOLERANCE = 1.02


@dataclass(frozen=True)
class VariogramFit:
    """Start of the simulations, with complete parameters.

    The misfit is the root mean square of ln(expected / inferred) over lags and axes, with more weight on the shortest
    lags.
    """

    parameters: FractalParameters
    misfit: float


def fit_variogram(underlying: Structure, image: CloudImage) -> VariogramFit:
    """Fit gamma, H, L and kmax to the variogram of the field that underlies an image.

    The normal scores of a frame have unit variance within the frame; a field with large cells has less
    (:meth:`KernelCorrelation.frame_variance`), and the expected variogram is divided by that variance. ``underlying``
    is from :func:`underlying_structure`; only the size and pixel size of the image are used. Raises ImageError if no
    parameters fit.
    """
    kernel = KernelCorrelation.tabulate()
    rows, columns = image.level.shape
    lags, nothing = underlying.lags, np.zeros_like(underlying.lags)
    dx, dy = np.concatenate([lags, nothing]), np.concatenate([nothing, lags])
    wanted = underlying.logarithm
    weight = np.where(dx + dy <= 2, _WEIGHT_OF_SHORT_LAGS, 1.0)

    def residuals(unknowns: Array, gamma: float, last: int) -> Array:
        shape = _parameters(unknowns, gamma, last, image)
        expected = kernel.expected_variogram(shape, image.pixel_size_m, dx, dy)
        variance = kernel.frame_variance(shape, image.pixel_size_m, rows, columns)
        return weight * (np.log(expected / variance) - wanted)

    longest, most = cells_per_frame(image)
    low = np.array([HURST[0], *np.log(longest)])
    high = np.array([HURST[1], *np.log(most)])
    fits: list[VariogramFit] = []
    for gamma in GAMMAS:
        unknowns = np.array([0.5, *np.clip(math.log(4.0), low[1:], high[1:])])
        # Octaves with more cells than pixels are white noise; one of them is enough.
        useful = math.ceil(math.log(max(rows, columns)) / math.log(gamma)) + 1
        for last in range(min(_MAX_OCTAVES, useful) + 1):
            solution = least_squares(
                residuals, unknowns, bounds=(low, high), args=(gamma, last), xtol=1e-4, ftol=1e-4, max_nfev=60
            )
            if np.all(np.isfinite(solution.fun)):
                misfit = float(np.sqrt(np.mean(solution.fun**2) / np.mean(weight**2)))
                fits.append(VariogramFit(_parameters(solution.x, gamma, last, image), misfit))
    if not fits:
        raise ImageError("image: no fractal field has a variogram like it")
    best = min(fit.misfit for fit in fits)
    good = [fit for fit in fits if fit.misfit <= _TOLERANCE * best]
    return min(good, key=lambda fit: (fit.parameters.k or (0, 0))[1])


def brightness_exponent(image: CloudImage) -> float:
    """Return the maximum-likelihood exponent s for scaled grey levels C = p^s with uniform p.

    As -ln C is exponentially distributed with mean s, the estimate is its sample mean. It is only a start value,
    because p is not quite uniform within one frame.
    """
    # Half a level is added so that the thinnest pixel has a finite logarithm.
    scaled = (image.level[image.cloudy].astype(np.float64) - 0.5) / 254.5
    return float(np.clip(-np.mean(np.log(scaled)), *BRIGHTNESS_EXPONENT))


def _parameters(unknowns: Array, gamma: float, last: int, image: CloudImage) -> FractalParameters:
    hurst, *cells = (float(value) for value in unknowns)
    return FractalParameters(gamma=gamma, H=hurst, L=reference_cells(np.exp(cells), image), k=(0, last))


Progress = Callable[[int], None]

# Weight w of the structure: an error of 10 % in the variogram, anisotropy or mean grey level counts as much as an RMSE
# of 1.5 %. Without it, four parameters would match four numbers and nothing else.
STRUCTURE_WEIGHT = 0.15

# Weight u of the surface dimension within the structure: an error of .05 counts as much as an error of 10 % in the
# variogram.
SURFACE_WEIGHT = 2.0

# Initial simplex steps: H, ln L along x and y, ln s.
_STEPS = np.array([0.08, 0.35, 0.35, 0.3])


@dataclass(frozen=True)
class Refinement:
    """Result of the refinement: complete parameters, the objective of :func:`refine`, and the image count."""

    parameters: FractalParameters
    objective: float
    simulations: int


class _Search:
    """Evaluates parameters and stores the best, because the optimiser may end elsewhere."""

    def __init__(
        self,
        image: CloudImage,
        structure: Structure,
        start: FractalParameters,
        seeds: tuple[int, ...],
        progress: Progress | None,
    ) -> None:
        self._image, self._structure, self._measured = image, structure, image.morphology()
        self._start, self._seeds, self._progress = start, seeds, progress
        self.best, self.objective, self.simulations = start, math.inf, 0

    def __call__(self, unknowns: Array) -> float:
        parameters = self._parameters(unknowns)
        images = [simulate_image(parameters, self._image.coverage, self._image, seed) for seed in self._seeds]
        self.simulations += len(images)
        if self._progress is not None:
            self._progress(len(images))
        shapes = [image.morphology() for image in images]
        errors = [morphology_errors(self._measured, shape).rmse for shape in shapes]
        mean = mean_structure([image_structure(image.level, self._structure.lags.tolist()) for image in images])
        variogram = float(np.mean((mean.logarithm - self._structure.logarithm) ** 2))
        anisotropy = _log_ratio([shape.anisotropy for shape in shapes], self._measured.anisotropy)
        level = _log_ratio([image.mean_level for image in images], self._image.mean_level)
        surface = float(np.mean([shape.surface_dimension for shape in shapes])) - self._measured.surface_dimension
        structure = variogram + anisotropy**2 + level**2 + (SURFACE_WEIGHT * surface) ** 2
        objective = math.sqrt(float(np.mean(np.square(errors))) + STRUCTURE_WEIGHT**2 * structure)
        if objective < self.objective:
            self.objective, self.best = objective, parameters
        return objective

    def _parameters(self, unknowns: Array) -> FractalParameters:
        hurst, *logarithms, exponent = (float(value) for value in unknowns)
        cells = reference_cells(np.exp(logarithms), self._image)
        return self._start.model_copy(update={"H": hurst, "L": cells, "brightness_exponent": math.exp(exponent)})


def _log_ratio(simulated: list[float], measured: float) -> float:
    return float(np.mean(np.log(simulated))) - math.log(measured)


def refine(
    image: CloudImage,
    structure: Structure,
    start: FractalParameters,
    seeds: tuple[int, ...],
    budget: int,
    progress: Progress | None = None,
) -> Refinement:
    """Refine H, L and the brightness exponent with the Nelder-Mead simplex and common random numbers.

    The objective is sqrt(E + w^2 (v + a^2 + g^2 + u^2 d^2)): E is the mean over seeds of the squared RMSE of eq 24, v
    the mean square of ln(simulated / measured) semivariance, a and g the same logarithms of the anisotropy and of the
    mean grey level, d the difference of surface dimensions; w = 0.15 and u = 2. E includes the scatter between
    realisations, which favours parameters that match in every realisation.

    Using the same seeds at every step makes the objective smooth, but its minimum depends on them: validate the result
    with other seeds. ``start`` is complete; its gamma and k are unchanged. ``budget`` limits the number of simulated
    images (at least one step); ``progress`` is called after each step with the number of images that it simulated.
    Raises ImageError if a simulated image does not vary.
    """
    if start.H is None or start.L is None:
        raise ValueError("start: H and L must be given")
    search = _Search(image, structure, start, seeds, progress)
    fewest, most = cells_per_frame(image)
    low = np.array([HURST[0], *np.log(fewest), math.log(BRIGHTNESS_EXPONENT[0])])
    high = np.array([HURST[1], *np.log(most), math.log(BRIGHTNESS_EXPONENT[1])])
    first = np.array([start.H, *np.log(frame_cells(start.L, image)), math.log(start.brightness_exponent)])
    first = np.clip(first, low, high)
    # Step away from a nearby limit; otherwise the simplex would be flat.
    steps = np.where(first + _STEPS <= high, _STEPS, -_STEPS)
    minimize(
        search,
        first,
        method="Nelder-Mead",
        bounds=list(zip(low, high, strict=True)),
        options={
            "initial_simplex": np.vstack([first, first + np.diag(steps)]),
            "maxfev": max(1, budget // len(seeds)),
            "xatol": 2e-3,
            "fatol": 1e-4,
        },
    )
    return Refinement(search.best, search.objective, search.simulations)
