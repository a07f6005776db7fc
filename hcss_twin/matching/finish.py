"""The last step by simulation: eq 24 and the variogram, over a few seeds that stay the same."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.evaluation.morphology import Morphology, morphology_errors
from hcss_twin.matching.bounds import BRIGHTNESS_EXPONENT, HURST, cells_per_frame, frame_cells, reference_cells
from hcss_twin.matching.cloud_image import CloudImage, simulate_image
from hcss_twin.matching.structure import Structure, image_structure

Array = NDArray[np.float64]

# A variogram that is wrong by 10 % counts as much as an RMSE of 2 %.
VARIOGRAM_WEIGHT = 0.2

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
        sqrt(mean over seeds of eq 24's RMSE^2 + (0.2 rms ln variogram ratio)^2) at them.
    simulations : int
        Images that were simulated.
    """

    parameters: FractalParameters
    objective: float
    simulations: int


@dataclass
class _Search:
    """Evaluates parameters and remembers the best: the optimiser may end elsewhere."""

    image: CloudImage
    structure: Structure
    start: FractalParameters
    seeds: tuple[int, ...]
    measured: Morphology = field(init=False)
    best: tuple[float, FractalParameters] = field(init=False)
    simulations: int = 0

    def __post_init__(self) -> None:
        self.measured = self.image.morphology()
        self.best = (math.inf, self.start)

    def parameters(self, unknowns: Array) -> FractalParameters:
        hurst, *cells, exponent = (float(value) for value in unknowns)
        return self.start.model_copy(
            update={
                "H": hurst,
                "L": reference_cells(np.exp(cells), self.image),
                "brightness_exponent": math.exp(exponent),
            }
        )

    def __call__(self, unknowns: Array) -> float:
        parameters = self.parameters(unknowns)
        images = [simulate_image(parameters, self.image.coverage, self.image, seed) for seed in self.seeds]
        self.simulations += len(images)
        shapes = [each.morphology() for each in images]
        errors = [morphology_errors(self.measured, each).rmse for each in shapes]
        ratio_ = np.mean([math.log(each.anisotropy) for each in shapes]) - math.log(self.measured.anisotropy)
        structures = [image_structure(each.level, self.structure.lags.tolist()) for each in images]
        ratio = np.log(np.mean([np.exp(each.logarithm) for each in structures], axis=0))
        misfit = float(np.mean((ratio - self.structure.logarithm) ** 2))
        lev = np.mean([math.log(each.level[each.cloudy].mean()) for each in images]) - math.log(self.image.level[self.image.cloudy].mean())
        objective = math.sqrt(float(np.mean(np.square(errors))) + VARIOGRAM_WEIGHT**2 * (misfit+ratio_**2+lev**2))
        if objective < self.best[0]:
            self.best = (objective, parameters)
        return objective


def refine(
    image: CloudImage, structure: Structure, start: FractalParameters, seeds: tuple[int, ...], budget: int
) -> Finish:
    """Refine H, L and the brightness exponent by Nelder-Mead with common random numbers.

    The same seeds at every step make the objective a smooth function, whose minimum depends on them:
    judge the result with others.

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
        Images to simulate at most, at least one step.

    Raises
    ------
    ImageError
        If a simulated image does not vary.
    """
    search = _Search(image, structure, start, seeds)
    fewest, most = cells_per_frame(image)
    low = np.array([HURST[0], *np.log(fewest), math.log(BRIGHTNESS_EXPONENT[0])])
    high = np.array([HURST[1], *np.log(most), math.log(BRIGHTNESS_EXPONENT[1])])
    assert start.H is not None and start.L is not None
    first = np.array([start.H, *np.log(frame_cells(start.L, image)), math.log(start.brightness_exponent)])
    first = np.clip(first, low, high)
    # Away from the nearer limit, or the simplex would be flat.
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
    objective, parameters = search.best
    return Finish(parameters, objective, search.simulations)
