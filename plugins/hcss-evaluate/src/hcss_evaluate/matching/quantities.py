"""Compare a matched image with its simulations, quantity by quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from hcss_evaluate.matching.structure import CloudImage, Structure
from hcss_twin.providers import Array

# Diagonal steps, in pixels along x and y.
_STEPS = (2, 4, 8)


def obliqueness(image: CloudImage) -> float:
    """Return the ratio of mean square differences along the two diagonals, at least 1.

    It is 1 for clouds that are isotropic or stretched along x or y, as eq 2 gives. The ratio is a geometric mean over
    diagonal steps of 2, 4 and 8 pixels.
    """
    level = image.level.astype(np.float64)
    ratios = []
    for step in _STEPS:
        rising = np.mean((level[step:, step:] - level[:-step, :-step]) ** 2)
        falling = np.mean((level[:-step, step:] - level[step:, :-step]) ** 2)
        ratios.append(math.log(rising / falling))
    return math.exp(abs(float(np.mean(ratios))))


def unevenness(image: CloudImage) -> float:
    """Return the standard deviation of the coverage over the four quarters of an image.

    The simulated field is stationary; a storm or a front in one corner is not.
    """
    cloudy = image.cloudy
    rows, columns = cloudy.shape
    quarters = [
        part.mean()
        for half in (cloudy[: rows // 2], cloudy[rows // 2 :])
        for part in (half[:, : columns // 2], half[:, columns // 2 :])
    ]
    return float(np.std(quarters))


# Largest relative error of the mean of the simulations that counts as matched.
CLOSE = 0.05

# The same for anisotropy, aspect and grey level, which are ratios.
_CLOSE_RATIO = 0.10

# The same for dimensions, as an absolute difference.
_CLOSE_DIMENSION = 0.05

# The same for semivariances at single lags, which scatter because a frame has few large clouds.
_CLOSE_SEMIVARIANCE = 0.25

# Quantities that no parameter controls count as different beyond this many standard deviations of the simulations.
_FAR_OUTSIDE = 2.0


@dataclass(frozen=True)
class MatchedQuantity:
    """One measure: its value in the image, and its mean and standard deviation over the simulations.

    Attributes
    ----------
    tolerance : float
        Largest |error| that counts as matched; infinity if the quantity is only shown.
    is_ratio : bool
        Whether the error is relative to the image's value; otherwise it is a difference. Eq 24 (the RMSE) divides by
        the simulated value instead.
    is_one_sided : bool
        Whether an image value below those of the simulations also counts as matched.
    """

    name: str
    meaning: str
    image: float
    simulated: float
    spread: float
    tolerance: float
    is_ratio: bool = True
    is_one_sided: bool = False

    @property
    def error(self) -> float:
        """(simulated - image) / image, or the difference; infinite if only the image's value is 0."""
        difference = self.simulated - self.image
        if not self.is_ratio or difference == 0.0:
            return difference
        return difference / self.image if self.image else math.copysign(math.inf, difference)

    @property
    def is_matched(self) -> bool:
        """Whether the error is within the tolerance; NaN counts as matched."""
        size = -self.error if self.is_one_sided else abs(self.error)
        return not size > self.tolerance


def compare(image: CloudImage, simulations: Sequence[CloudImage]) -> tuple[MatchedQuantity, ...]:
    """Measure all quantities in the image and in the simulations.

    Raises ImageError if an image has too little measurable cloud.
    """
    measured = image.morphology()
    shapes = [simulation.morphology() for simulation in simulations]
    rows = (
        ("EV", "entropy of neighbouring grey levels, bits", "entropy", CLOSE, True),
        ("Den", "mean of 1 / (1 + difference of neighbours)", "density", CLOSE, True),
        ("DP", "pairs of equal neighbours / 255", "diagonal_peak", CLOSE, True),
        ("FD", "fractal dimension, boxes that fill the cloud", "fractal_dimension", CLOSE, True),
        ("coverage", "cloudy part of the pixels", "coverage", CLOSE, True),
        ("surface", "fractal dimension of the grey levels, variogram", "surface_dimension", _CLOSE_DIMENSION, False),
        ("boundary", "fractal dimension of the outlines", "boundary_dimension", _CLOSE_DIMENSION, False),
        ("anisotropy", "semivariance along y / along x, 1-2 pixels", "anisotropy", _CLOSE_RATIO, True),
        ("aspect", "length along x / along y", "aspect", _CLOSE_RATIO, True),
    )  # fmt: skip
    quantities = []
    for name, meaning, field, close, is_ratio in rows:
        values = [getattr(shape, field) for shape in shapes]
        mean, spread = float(np.mean(values)), float(np.std(values))
        quantities.append(MatchedQuantity(name, meaning, getattr(measured, field), mean, spread, close, is_ratio))
    levels = [simulation.mean_level for simulation in simulations]
    mean, spread = float(np.mean(levels)), float(np.std(levels))
    meaning = "mean grey level of cloud"
    quantities.append(MatchedQuantity("level", meaning, image.mean_level, mean, spread, _CLOSE_RATIO))
    for name, meaning, measure in (
        ("oblique", "ratio of differences along the two diagonals", obliqueness),
        ("uneven", "scatter of the coverage of the four quarters", unevenness),
    ):
        values = [measure(simulation) for simulation in simulations]
        mean, spread = float(np.mean(values)), float(np.std(values))
        limit = _FAR_OUTSIDE * spread
        quantities.append(MatchedQuantity(name, meaning, measure(image), mean, spread, limit, False, True))
    return tuple(quantities)


def describe_unmatched(
    quantities: Sequence[MatchedQuantity], image: Structure, simulated: Structure
) -> tuple[str, ...]:
    """Describe the quantities that differ, with the reason if it is known."""
    lines = []
    for quantity in quantities:
        if quantity.is_matched:
            continue
        size = f"{quantity.error:+.1%}" if quantity.is_ratio else f"{quantity.error:+.3g}"
        why = _WHY.get(quantity.name, "")
        lines.append(
            f"{quantity.name} ({quantity.meaning}): image {quantity.image:.4g}, simulated {quantity.simulated:.4g} +- "
            f"{quantity.spread:.2g} ({size}){'; ' + why if why else ''}"
        )
    for axis in ("x", "y"):
        ratio = np.log(getattr(simulated, f"along_{axis}") / getattr(image, f"along_{axis}"))
        bad = np.abs(ratio) > math.log1p(_CLOSE_SEMIVARIANCE)
        if bad.any():
            listed = ", ".join(
                f"{lag} px {math.expm1(value):+.0%}" for lag, value in zip(image.lags[bad], ratio[bad], strict=True)
            )
            lines.append(f"semivariance along {axis}: {listed} in the simulations, relative to the image")
    return tuple(lines)


_WHY = {
    "surface": "one exponent for all scales; real clouds are smoother or rougher at the scale of pixels",
    "boundary": "outlines and grey levels of a Gaussian field have one roughness, those of real clouds two",
    "anisotropy": "one ratio of lengths for all scales",
    "aspect": "one ratio of lengths for all scales",
    "oblique": "the lattices of eq 2 stretch along x and y only",
    "uneven": "the field is statistically homogeneous; a storm or a front is not",
}


_LAGS = 1, 2, 4, 8  # pixels
_ALIGNED_PIXELS = 3.0

MAX_RATIO = 1.25
"""An image this many times as far as the farthest realisation is no fractal field: one in 40 fractal fields is, and
nearly all parts of SEVIRI images are (docs/how-to/match-and-fit.md)."""


@dataclass(frozen=True)
class Likeness:
    """Distance of an image to the realisations of its match, and of each realisation to the others (N,).

    Those of the group of measures that tells more.
    """

    distance: float
    of_realisations: tuple[float, ...]

    @property
    def ratio(self) -> float:
        """Distance of the image over that of the farthest realisation."""
        return self.distance / max(*self.of_realisations, 1e-9)

    @property
    def unmatched(self) -> tuple[str, ...]:
        """A line that says that no fractal field looks like the image, if so."""
        line = (
            f"no fractal field looks like this image: in kurtosis, skewness and local direction at 1 to 8 pixels it is "
            f"{self.ratio:.1f} times as far from the realisations of its match as any of them from the others. "
            "Simulate its cells, streets, fibres or edges from the image itself: generators `imagery`, "
            "`surrogate` and `example` (hcss-skies)"
        )
        return (line,) if self.ratio > MAX_RATIO else ()


def likeness(image: CloudImage, realisations: Sequence[CloudImage]) -> Likeness:
    """Measure distances in standard deviations of the realisations; the search does not fit what is compared.

    One group of measures are kurtosis and skewness at all lags, the other kurtosis at 1 pixel and alignment.
    """
    found, of_image = np.stack([_organisation(realisation) for realisation in realisations]), _organisation(image)
    groups = []
    for measures in (slice(0, 2 * len(_LAGS)), [0, 2 * len(_LAGS)]):
        simulated = found[:, measures]
        among = tuple(_distance(values, np.delete(simulated, index, axis=0)) for index, values in enumerate(simulated))
        groups.append(Likeness(_distance(of_image[measures], simulated), among))
    return max(groups, key=lambda group: group.ratio)


def alignment(level: Array) -> float:
    """Return how far the gradients of neighbours agree in direction, 0 to 1: coherence of the structure tensor.

    The image is smoothed by 1 pixel, the tensor by 3; mean over pixels, weighted by the squared gradient (J. Bigun and
    G. H. Granlund, Proc. ICCV, London 1987, p. 433).
    """
    along_y, along_x = np.gradient(gaussian_filter(level, 1.0))
    yy, xx, xy = (
        gaussian_filter(product, _ALIGNED_PIXELS)
        for product in (along_y * along_y, along_x * along_x, along_y * along_x)
    )
    return float(np.hypot(yy - xx, 2.0 * xy).sum() / max(float((yy + xx).sum()), 1e-12))


def _organisation(image: CloudImage) -> Array:
    """Return the logarithm of the kurtosis of differences and the skewness of the Laplacian at each lag; alignment."""
    level, numbers = image.level.astype(np.float64), []
    for lag in _LAGS:
        steps = np.concatenate([(level[lag:] - level[:-lag]).ravel(), (level[:, lag:] - level[:, :-lag]).ravel()])
        inside = slice(lag, -lag)
        around = level[2 * lag :, inside] + level[: -2 * lag, inside] + level[inside, 2 * lag :]
        bend = 4.0 * level[inside, inside] - around - level[inside, : -2 * lag]
        numbers += [np.log(np.mean(steps**4) / np.mean(steps**2) ** 2), np.mean(bend**3) / np.mean(bend**2) ** 1.5]
    return np.array([*numbers, alignment(level)])


def _distance(numbers: Array, realisations: Array) -> float:
    spread = np.maximum(np.std(realisations, axis=0, ddof=1), 1e-9)
    return float(np.sqrt(np.mean(((numbers - np.mean(realisations, axis=0)) / spread) ** 2)))
