"""Algorithm 1 of the HCSS paper as printed: find parameters that give a fractal dimension in a requested range."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Literal

import numpy as np

from hcss_evaluate.matching.match import FRESH_SEEDS, SEARCH_SEEDS, clouds_fragment, rounded
from hcss_evaluate.matching.structure import CloudImage, simulate_image
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import Array, Catalog, ImageError

Dimension = Literal["fractal", "surface"]

# Factors of L to try, the smallest change first, and Hurst exponents for each.
_FACTORS = (1.0, 2.0, 0.5, 4.0, 0.25)
_HURST = (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95)

# Bisection steps between two Hurst exponents that bracket the target dimension.
_BISECTIONS = 6
_APART = 1000


@dataclass(frozen=True)
class DimensionMatch:
    """Parameters that give the requested dimension.

    Attributes
    ----------
    parameters : FractalParameters
        Complete, and rounded as in the written file.
    dimension : {"fractal", "surface"}
        Attribute of :class:`hcss_evaluate.measures.morphology.Morphology` without ``_dimension``.
    dimensions, seeds : tuple
        Dimensions and seeds of the validation simulations; the search has not used these seeds.
    changed : str
        Description of the changes to the start parameters.
    """

    parameters: FractalParameters
    dimension: Dimension
    wanted: tuple[float, float]
    dimensions: tuple[float, ...]
    seeds: tuple[int, ...]
    changed: str

    @property
    def inside(self) -> float:
        """Fraction of the validation simulations with a dimension in the range."""
        low, high = self.wanted
        return float(np.mean([low <= value <= high for value in self.dimensions]))


def match_dimension(
    wanted: tuple[float, float],
    start: FractalParameters,
    coverage: float,
    like: CloudImage,
    dimension: Dimension = "fractal",
    seed: int = 0,
) -> DimensionMatch:
    """Adjust H, and L only if H is not enough, until the mean dimension lies in a range within 2 to 3.

    A dimension may be non-monotonic in H, as the body dimension is. H is therefore scanned first, and the solution
    nearest to the (complete) start parameters is selected. The target is the middle of the range if the scan crosses
    it. Raises ImageError if the range is invalid or no mean lies in it; the message gives the values that were reached.

    Parameters
    ----------
    coverage : float
        Fraction of cloudy pixels, the main control of the body dimension.
    like : CloudImage
        Image with the size and pixel size to simulate; its grey levels are not used.
    dimension : {"fractal", "surface"}
        The dimension in the paper's tables, or that from the variogram of grey levels.
    seed : int
        The search uses this seed and the next five; the mean over ten seeds from seed + 1000 on must lie in the range
        as well.
    """
    low, high = wanted
    if not 2.0 <= low < high <= 3.0:
        raise ImageError(f"fractal dimension: {low:g} to {high:g} given, allowed: 2 <= low < high <= 3")
    if start.H is None or start.L is None:
        raise ImageError("start: H and L must be given")
    start_hurst = start.H
    middle = 0.5 * (low + high)
    search_seeds = tuple(range(seed, seed + SEARCH_SEEDS))
    fresh_seeds = tuple(range(seed + _APART, seed + _APART + FRESH_SEEDS))

    def with_changes(hurst: float, factor: float) -> FractalParameters:
        x, y = start.L or (1.0, 1.0)
        return rounded(start.model_copy(update={"H": hurst, "L": (factor * x, factor * y)}))

    def mean(factor: float, hurst: float) -> float:
        parameters = with_changes(hurst, factor)
        return float(np.mean(dimensions(parameters, coverage, like, dimension, search_seeds)))

    reached: list[float] = []
    for factor in _FACTORS:
        tried = sorted({*_HURST, min(max(start.H, _HURST[0]), _HURST[-1])})
        means = {hurst: mean(factor, hurst) for hurst in tried}
        reached += means.values()
        for left, right in pairwise(tried):
            if (means[left] - middle) * (means[right] - middle) < 0.0:
                crossing = _bisect(partial(mean, factor), middle, left, right, means[left])
                means[crossing] = mean(factor, crossing)
        # Try the middle half of the range first, so that most images, not only the mean, lie in it.
        for margin in (0.25 * (high - low), 0.0):
            inside = [hurst for hurst, value in means.items() if low + margin <= value <= high - margin]
            if not inside:
                continue
            parameters = with_changes(min(inside, key=lambda hurst: abs(hurst - start_hurst)), factor)
            fresh = dimensions(parameters, coverage, like, dimension, fresh_seeds)
            # If a frame has few clouds, the mean of six may lie inside by chance.
            if low <= np.mean(fresh) <= high:
                return DimensionMatch(
                    parameters, dimension, wanted, tuple(fresh.tolist()), fresh_seeds, _changes(start, parameters)
                )
            reached.append(float(np.mean(fresh)))
    nearest = min(reached, key=lambda value: abs(value - middle))
    raise ImageError(
        f"{dimension} dimension: mean of {low:g} to {high:g} not reached with gamma {start.gamma:g} and k {start.k} at "
        f"a coverage of {coverage:g}: H from {_HURST[0]:g} to {_HURST[-1]:g} and L from a quarter to four times "
        f"{list(start.L)} give {min(reached):.3f} to {max(reached):.3f}; closest is {nearest:.3f}. Allowed: another "
        "coverage, type or range"
    )


def dimensions(
    parameters: FractalParameters, coverage: float, like: CloudImage, dimension: Dimension, seeds: tuple[int, ...]
) -> Array:
    """Return the dimension (N,) of a simulation for each seed."""
    images = (simulate_image(parameters, coverage, like, seed) for seed in seeds)
    return np.array([getattr(image.morphology(), f"{dimension}_dimension") for image in images])


def _bisect(function: Callable[[float], float], level: float, left: float, right: float, value: float) -> float:
    """Return the point where ``function`` crosses ``level``; ``value`` is ``function(left)``."""
    for _ in range(_BISECTIONS):
        middle = 0.5 * (left + right)
        if (function(middle) - level) * (value - level) > 0.0:
            left = middle
        else:
            right = middle
    return 0.5 * (left + right)


def _changes(start: FractalParameters, changed: FractalParameters) -> str:
    parts = []
    if changed.H != start.H:
        parts.append(f"H from {start.H:g} to {changed.H:g}")
    if changed.L != start.L:
        parts.append(f"L from {list(start.L or ())} to {list(changed.L or ())}")
    return " and ".join(parts) or "nothing"


# The frame of the paper's tables.
SIDE = 800
PIXEL_SIZE_M = 20.0


def type_parameters(cloud_type: str, catalog: Catalog) -> FractalParameters:
    """Return the complete parameters of a cloud type of the catalog.

    Raises CatalogError if there is no such type.
    """
    shape = catalog.toml(catalog.find(cloud_type, "cloud_types", ".toml"))["fractal"]
    x, y = shape["L"]
    first, last = shape["k"]
    return FractalParameters(gamma=float(shape["gamma"]), H=float(shape["H"]), L=(float(x), float(y)), k=(first, last))


def empty_frame(rows: int = SIDE, columns: int = SIDE, pixel_size_m: float = PIXEL_SIZE_M) -> CloudImage:
    """Return an empty frame of a given size, by default that of the paper."""
    return CloudImage(np.zeros((rows, columns), dtype=np.float32), pixel_size_m)


def dimension_fragment(
    match: DimensionMatch, coverage: float, like: CloudImage, started_from: str, cloud_type: str
) -> str:
    """Return TOML as :func:`match_fragment` does, for a range of the fractal dimension.

    ``started_from`` names the source of the start parameters.
    """
    low, high = match.wanted
    mean = sum(match.dimensions) / len(match.dimensions)
    comments = [
        f"Clouds with a {match.dimension} dimension of {low:g} to {high:g}, found by hcss match from the "
        f"parameters of {started_from}; changed: {match.changed}.",
        f"Over {len(match.seeds)} seeds not used in the search it is {mean:.3f} ({min(match.dimensions):.3f} "
        f"to {max(match.dimensions):.3f}); {match.inside:.0%} of them lie in the range.",
    ]
    return clouds_fragment(match.parameters, coverage, like, cloud_type, comments)
