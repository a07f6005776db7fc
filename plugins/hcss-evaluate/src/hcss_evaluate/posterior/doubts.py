"""Reasons to doubt a posterior, of which the report and the command warn.

A posterior is right if the image is a fractal field of the assumed octaves, and if its priors contain it. Checks find
where that is not so: the fitted variogram lies outside what the posterior predicts, statistics that the fit does not
use do, draws crowd at a limit, or the image shows few of its largest cells. An interval of draws with two modes covers
values between them that the image excludes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from hcss_evaluate.matching.quantities import MAX_RATIO, likeness
from hcss_evaluate.matching.structure import CloudImage
from hcss_evaluate.posterior.image_data import image_scores
from hcss_evaluate.posterior.image_likelihood import ImageLikelihood, on_scales
from hcss_evaluate.posterior.parameter_space import SHAPE, Space
from hcss_evaluate.posterior.posterior_file import SUSPICIOUS
from hcss_evaluate.posterior.priors import KINDS
from hcss_twin.models.clouds.fractal.octaves import Octave
from hcss_twin.providers import Array

# Images drawn from the posterior, whose differences show how far the image may be from them.
_REALISATIONS = 20

# An image that shows fewer of the largest cells cannot tell that there are no larger ones.
_FEWEST_CELLS = 4.0

# Fraction of the half-width of the range that counts as its edge, and the fraction of draws there that triggers a
# warning. Uniform draws have a fraction of _EDGE there.
_EDGE, _CROWDED = 0.02, 0.06

# Two modes: their valley is below this part of the lower one, and both have at least this share of the draws.
_DEEP_VALLEY, _SMALLEST_MODE = 0.5, 0.05

_DENSITY_CELLS = 512


def unlikeness(
    image: CloudImage, likelihood: ImageLikelihood, values: Array, lasts: NDArray[np.int64], rng: np.random.Generator
) -> float:
    """Return how far an image is from images drawn from its posterior, over how far these are from each other.

    Compared are kurtosis, skewness and alignment at 1 to 8 pixels of normal scores, none of which the fit uses
    (:func:`hcss_evaluate.matching.quantities.likeness`). ``values`` are draws (N, 5) of all parameters, ``lasts``
    (N,) of the last octave.
    """
    data = likelihood.data
    drawn = []
    for row in rng.integers(0, values.shape[0], _REALISATIONS):
        octaves = likelihood.variogram.octaves.first, int(lasts[row])
        scores, _ = data.simulate(values[row, : len(SHAPE)], octaves, int(rng.integers(0, 2**31)))
        drawn.append(CloudImage(scores, data.pixel_size_m))
    return likeness(CloudImage(image_scores(image.level), data.pixel_size_m), drawn).ratio


@dataclass(frozen=True)
class Doubt:
    """A reason to doubt the intervals of some parameters of an image."""

    image: str
    parameters: tuple[str, ...]
    reason: str


def doubts(
    name: str,
    likelihood: ImageLikelihood,
    values: Array,
    space: Space,
    p_value: float,
    unlike: float,
    cloud_type: str | None,
) -> Iterator[Doubt]:
    """Yield what is doubtful of an image's posterior, given its predictive p-value and :func:`unlikeness`."""
    if p_value < SUSPICIOUS:
        yield Doubt(
            name,
            space.names,
            f"no fractal field has such a variogram (posterior predictive p = {p_value:.2g}): intervals are too "
            "narrow; a misfit greater than 0 or a larger smallest lag allows for that",
        )
    if unlike > MAX_RATIO:
        yield Doubt(
            name,
            space.names,
            "no image drawn from the posterior looks like this one: in kurtosis, skewness and local direction it is "
            f"{unlike:.1f} times as far from them as they are from each other",
        )
    yield from _at_edges(name, likelihood, values, space)
    yield from _two_modes(name, values, space)
    if cloud_type is None:
        yield from _few_cells(name, likelihood, values, space)


def _at_edges(name: str, likelihood: ImageLikelihood, values: Array, space: Space) -> Iterator[Doubt]:
    """Yield parameters with many draws at the edge of the prior or of the simulated region."""
    noise = likelihood.noise
    assert noise is not None
    position = on_scales(values[:, : len(SHAPE)])
    for column, parameter in enumerate(SHAPE):
        if parameter in space.fixed:
            continue
        away = np.abs(position[:, column] - noise.centre[column]) / noise.width[column]
        part = float(np.mean(away > 1.0 - _EDGE))
        if part > _CROWDED:
            yield Doubt(
                name,
                (parameter,),
                f"{part:.0%} of the draws of {parameter} lie at the edge of the prior or of the simulated range: the "
                "interval shows that limit, not the data",
            )


def _two_modes(name: str, values: Array, space: Space) -> Iterator[Doubt]:
    """Yield parameters whose draws have two modes."""
    for column, (parameter, kind) in enumerate(KINDS.items()):
        if parameter in space.fixed:
            continue
        modes = main_modes(kind.scale.of(values[:, column]))
        if len(modes) > 1:
            places = " and ".join(
                f"{float(kind.scale.back(np.array(place))):.3g} ({share:.0%} of the draws)" for place, share in modes
            )
            yield Doubt(
                name,
                (parameter,),
                f"the draws of {parameter} have two modes, at {places}: its interval covers values between them that "
                "the image excludes, and its mean may be one; a prior that excludes a mode parts them",
            )


def main_modes(draws: Array) -> list[tuple[float, float]]:
    """Return place and share of the draws (N,) of each of the two main modes; one if no second one stands out.

    The density is estimated with a Gaussian kernel of Silverman's width (B. W. Silverman, Density Estimation for
    Statistics and Data Analysis (1986), Eq. 3.31). The draws are parted at the lowest valley, relative to the lower of
    the maxima on both sides of it.
    """
    low, middle, high = np.quantile(draws, (0.25, 0.5, 0.75))
    spread = min(float(np.std(draws)), float(high - low) / 1.34)
    if not spread > 0.0:
        return [(float(middle), 1.0)]
    width = 0.9 * spread * draws.size**-0.2
    edges = np.linspace(draws.min() - 3.0 * width, draws.max() + 3.0 * width, _DENSITY_CELLS + 1)
    cell = float(edges[1] - edges[0])
    counts = np.histogram(draws, edges)[0].astype(np.float64)
    density = gaussian_filter1d(counts, width / cell, mode="constant", truncate=6.0)
    left, right = np.maximum.accumulate(density), np.maximum.accumulate(density[::-1])[::-1]
    # not in the tails, where single draws have gaps between them
    share = np.cumsum(counts) / draws.size
    depth = np.where(np.abs(share - 0.5) < 0.5 - _SMALLEST_MODE, density / np.minimum(left, right), 1.0)
    valley = int(np.argmin(depth))
    if depth[valley] >= _DEEP_VALLEY:
        return [(float(edges[int(np.argmax(density))]) + 0.5 * cell, 1.0)]
    peaks = int(np.argmax(density[:valley])), valley + int(np.argmax(density[valley:]))
    parts = float(share[valley]), 1.0 - float(share[valley])
    return [(float(edges[peak]) + 0.5 * cell, part) for peak, part in zip(peaks, parts, strict=True)]


def _few_cells(name: str, likelihood: ImageLikelihood, values: Array, space: Space) -> Iterator[Doubt]:
    """Yield a doubt where the image shows few of the largest cells.

    Larger ones outside it would change L, and with it the number of octaves that gamma puts into the image. Where the
    last octave is unknown, too, H follows: steep spectra and spectra that end early look alike in few cells.
    """
    data = likelihood.data
    last_is_known = likelihood.variogram.octaves.known is not None
    concerned = ("gamma", "Lx", "Ly", "coverage") if last_is_known else ("H", "gamma", "Lx", "Ly", "coverage")
    free = tuple(name for name in concerned if name in space.names)
    sides = {"Lx": data.columns * data.pixel_size_m, "Ly": data.rows * data.pixel_size_m}
    cells = {
        axis: float(np.median(values[:, SHAPE.index(axis)])) * side / Octave.REFERENCE_LENGTH_M
        for axis, side in sides.items()
    }
    least = min(cells, key=lambda axis: cells[axis])
    if free and cells[least] < _FEWEST_CELLS:
        yield Doubt(
            name,
            free,
            f"the image is {cells[least]:.1f} of its largest cells wide along {least[1:]}: {', '.join(free)} hold "
            "if there are no larger ones (--type, or priors of L, state what there is)",
        )
