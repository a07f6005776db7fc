"""The last step by simulation: eq 24 and the structure, over a few seeds that stay the same."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from hcss_twin.analysis.matching.start import BRIGHTNESS_EXPONENT, HURST, cells_per_frame, frame_cells, reference_cells
from hcss_twin.analysis.matching.structure import CloudImage, Structure, image_structure, mean_structure, simulate_image
from hcss_twin.analysis.measures.morphology import Morphology, morphology_errors
from hcss_twin.core.arrays import Array
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

Progress = Callable[[int], None]

# Weight w of the structure: a variogram, an anisotropy or a mean grey level that is wrong by 10 % counts as
# much as an RMSE of 1.5 %. Without it four numbers would be matched by four parameters, and anything else
# could be lost.
STRUCTURE_WEIGHT = 0.15

# Weight u of the surface dimension within the structure: one that is wrong by .05 counts as much as a
# variogram that is wrong by 10 %.
SURFACE_WEIGHT = 2.0

# First steps of the simplex: H, ln L along x and y, ln s.
_STEPS = np.array([0.08, 0.35, 0.35, 0.3])


@dataclass(frozen=True)
class Finish:
    """What the simulations found.

    Attributes
    ----------
    parameters : FractalParameters
        Complete.
    objective : float
        What was made small; see :func:`refine`.
    simulations : int
        Images that were simulated.
    """

    parameters: FractalParameters
    objective: float
    simulations: int


class _Search:
    """Evaluates parameters and remembers the best: an optimiser may end elsewhere."""

    def __init__(
        self,
        image: CloudImage,
        structure: Structure,
        start: FractalParameters,
        seeds: tuple[int, ...],
        progress: Progress | None,
    ) -> None:
        self._image = image
        self._structure = structure
        self._measured: Morphology = image.morphology()
        self._start = start
        self._seeds = seeds
        self._progress = progress
        self.best = start
        self.objective = math.inf
        self.simulations = 0

    def __call__(self, unknowns: Array) -> float:
        parameters = self._parameters(unknowns)
        images = [simulate_image(parameters, self._image.coverage, self._image, seed) for seed in self._seeds]
        self.simulations += len(images)
        if self._progress is not None:
            self._progress(len(images))
        shapes = [each.morphology() for each in images]
        errors = [morphology_errors(self._measured, each).rmse for each in shapes]
        mean = mean_structure([image_structure(each.level, self._structure.lags.tolist()) for each in images])
        variogram = float(np.mean((mean.logarithm - self._structure.logarithm) ** 2))
        anisotropy = _log_ratio([each.anisotropy for each in shapes], self._measured.anisotropy)
        level = _log_ratio([each.mean_level for each in images], self._image.mean_level)
        surface = float(np.mean([each.surface_dimension for each in shapes])) - self._measured.surface_dimension
        structure = variogram + anisotropy**2 + level**2 + (SURFACE_WEIGHT * surface) ** 2
        objective = math.sqrt(float(np.mean(np.square(errors))) + STRUCTURE_WEIGHT**2 * structure)
        if objective < self.objective:
            self.objective, self.best = objective, parameters
        return objective

    def _parameters(self, unknowns: Array) -> FractalParameters:
        hurst, *cells, exponent = (float(value) for value in unknowns)
        return self._start.model_copy(
            update={
                "H": hurst,
                "L": reference_cells(np.exp(cells), self._image),
                "brightness_exponent": math.exp(exponent),
            }
        )


def _log_ratio(simulated: list[float], measured: float) -> float:
    return float(np.mean(np.log(simulated))) - math.log(measured)


def refine(
    image: CloudImage,
    structure: Structure,
    start: FractalParameters,
    seeds: tuple[int, ...],
    budget: int,
    progress: Progress | None = None,
) -> Finish:
    """Refine H, L and the brightness exponent by Nelder and Mead's simplex with common random numbers.

    Made small is sqrt(E + w^2 (v + a^2 + g^2 + u^2 d^2)): E is the mean over seeds of the square of
    eq 24's RMSE, v the mean square of ln(simulated / measured) semivariance, a and g those logarithms of
    the anisotropy and of the mean grey level, d the difference of surface dimensions; w = 0.15 and u = 2.
    E holds the scatter between realisations too, so that parameters are preferred whose every image is
    like the measured one.

    The same seeds at every step make it a smooth function, whose minimum depends on them: judge the
    result with others.

    Parameters
    ----------
    image : CloudImage
        What is to be matched.
    structure : Structure
        Its semivariances.
    start : FractalParameters
        Complete; gamma and k stay.
    seeds : tuple of int
        Realisations per step.
    budget : int
        Images to simulate at most; one step at least.
    progress : callable, optional
        Is told after each step how many images it simulated.

    Raises
    ------
    ImageError
        If a simulated image does not vary.
    """
    if start.H is None or start.L is None:
        raise ValueError("start: H and L must be given")
    search = _Search(image, structure, start, seeds, progress)
    fewest, most = cells_per_frame(image)
    low = np.array([HURST[0], *np.log(fewest), math.log(BRIGHTNESS_EXPONENT[0])])
    high = np.array([HURST[1], *np.log(most), math.log(BRIGHTNESS_EXPONENT[1])])
    first = np.array([start.H, *np.log(frame_cells(start.L, image)), math.log(start.brightness_exponent)])
    first = np.clip(first, low, high)
    # Away from a near limit, or the simplex would be flat.
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
    return Finish(search.best, search.objective, search.simulations)
