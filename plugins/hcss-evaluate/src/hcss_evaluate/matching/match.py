"""Algorithm 1 of the HCSS paper: find generator parameters for an image's morphology, and write TOML."""

from __future__ import annotations

import json
import math
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_evaluate.matching import BUDGET
from hcss_evaluate.matching.quantities import Likeness, MatchedQuantity, compare, describe_unmatched, likeness
from hcss_evaluate.matching.search import (
    BRIGHTNESS_EXPONENT,
    FEWEST_CELLS,
    HURST,
    Progress,
    brightness_exponent,
    fit_variogram,
    frame_cells,
    refine,
)
from hcss_evaluate.matching.structure import (
    CloudImage,
    Structure,
    image_structure,
    mean_structure,
    octave_lags,
    simulate_image,
    underlying_structure,
)
from hcss_evaluate.matching.target import Target
from hcss_evaluate.measures.morphology import morphology_errors
from hcss_twin.core.files import Writing
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.providers import CatalogError, ImageError

# Realisations per search step, and realisations for validating the result.
SEARCH_SEEDS = 6
FRESH_SEEDS = 10

# Offset of the validation seeds from those of the search.
_APART = 1000

# A parameter this near to a limit counts as limited by it.
_NEAR = 1.02


@dataclass(frozen=True)
class Match:
    """Parameters, with the differences between images simulated with them and the measured image.

    Attributes
    ----------
    parameters : FractalParameters
        Complete, and rounded as in the written file.
    quantities : tuple of MatchedQuantity
        Comparison of the image with the validation simulations.
    rmse, start_rmse : tuple of float
        RMSE of eq 24 for each validation simulation, as a fraction, and the same for the analytic start.
    seeds : tuple of int
        Seeds of the validation simulations, which the search has not used.
    structure, simulated_structure : Structure
        Semivariances of the image, and their means over the validation simulations.
    simulations : int
        Number of images that the search simulated.
    likeness : Likeness
        Of the image and the validation simulations.
    unmatched : tuple of str
        What differs; the first says so if no fractal field looks like the image.
    """

    target: Target
    parameters: FractalParameters
    quantities: tuple[MatchedQuantity, ...]
    rmse: tuple[float, ...]
    seeds: tuple[int, ...]
    structure: Structure
    simulated_structure: Structure
    start_rmse: tuple[float, ...]
    simulations: int
    likeness: Likeness
    unmatched: tuple[str, ...]

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels in the image."""
        return self.target.image.coverage

    @property
    def mean_rmse(self) -> float:
        """Mean RMSE of eq 24 over the validation seeds, as a fraction."""
        return float(np.mean(self.rmse))

    @property
    def typical_seed(self) -> int:
        """Validation seed with the (lower) median RMSE, as a representative realisation."""
        return self.seeds[int(np.argsort(self.rmse)[(len(self.rmse) - 1) // 2])]

    def simulate(self, seed: int) -> CloudImage:
        """Simulate one frame like the image."""
        return simulate_image(self.parameters, self.coverage, self.target.image, seed)


def match(target: Target, seed: int = 0, budget: int = BUDGET, progress: Progress | None = None) -> Match:
    """Find parameters of the fractal generator that reproduce an image.

    The variogram of the underlying normal field gives gamma, H, L and k without simulation; simulations then refine H,
    L and the brightness exponent. Coverage is exact by construction. The search uses the seed and the next five and may
    simulate ``budget`` images (0 keeps the analytic start); the validation uses ten seeds from seed + 1000 on.
    ``progress`` is called after each step with the number of images that it simulated. Raises ImageError if the image
    has too little measurable cloud, or the budget or the seed is negative.
    """
    if seed < 0 or budget < 0:
        raise ImageError(f"seed, budget: {seed} and {budget} given, allowed: 0 or more")
    image = target.image
    measured = image.morphology()
    lags = octave_lags(image.level.shape)
    structure = image_structure(image.level, lags)
    start = fit_variogram(underlying_structure(image.level, structure), image)
    first = start.parameters.model_copy(update={"brightness_exponent": brightness_exponent(image)})
    best, simulations = first, 0
    if budget > 0:
        refinement = refine(image, structure, first, tuple(range(seed, seed + SEARCH_SEEDS)), budget, progress)
        best, simulations = refinement.parameters, refinement.simulations
    best = rounded(best)
    fresh = tuple(range(seed + _APART, seed + _APART + FRESH_SEEDS))
    images = [simulate_image(best, image.coverage, image, seed) for seed in fresh]
    begun = [simulate_image(first, image.coverage, image, seed) for seed in fresh] if budget else images
    simulated = mean_structure([image_structure(realisation.level, lags) for realisation in images])
    quantities, alike = compare(image, images), likeness(image, images)
    return Match(
        target=target,
        parameters=best,
        quantities=quantities,
        rmse=tuple(morphology_errors(measured, realisation.morphology()).rmse for realisation in images),
        seeds=fresh,
        structure=structure,
        simulated_structure=simulated,
        start_rmse=tuple(morphology_errors(measured, realisation.morphology()).rmse for realisation in begun),
        simulations=simulations,
        likeness=alike,
        unmatched=(*alike.unmatched, *_at_limits(best, image), *describe_unmatched(quantities, structure, simulated)),
    )


def rounded(parameters: FractalParameters) -> FractalParameters:
    """Round H, L and the brightness exponent to four digits, so that the written parameters are the validated ones."""
    if parameters.H is None or parameters.L is None:
        raise ValueError("parameters: H and L must be given")
    hurst, x, y, exponent = (
        float(f"{value:.4g}") for value in (parameters.H, *parameters.L, parameters.brightness_exponent)
    )
    return parameters.model_copy(update={"H": hurst, "L": (x, y), "brightness_exponent": exponent})


def _at_limits(parameters: FractalParameters, image: CloudImage) -> list[str]:
    """Return messages for parameters that ended at a limit of the search."""
    cells = frame_cells(parameters.L or (math.nan, math.nan), image)
    lines = []
    for axis, number in zip("xy", cells, strict=True):
        if number < _NEAR * FEWEST_CELLS:
            lines.append(
                f"L along {axis}: at its limit of {FEWEST_CELLS:g} cell per frame; the largest structures are as "
                "large as the image or larger"
            )
    for name, value, limits in (
        ("H", parameters.H or math.nan, HURST),
        ("brightness_exponent", parameters.brightness_exponent, BRIGHTNESS_EXPONENT),
    ):
        if not _NEAR * limits[0] < value < limits[1] / _NEAR:
            lines.append(f"{name}: {value:g} is at the limit of the search, {limits[0]:g} to {limits[1]:g}")
    return lines


_WIDTH = 110


def match_fragment(match: Match, cloud_type: str) -> str:
    """Return TOML: the section ``[clouds]`` with comments on its source and the quality of the match.

    It can be appended to any scenario file without clouds; a comment states the image size and pixel size of the
    validation.
    """
    best, worst = min(match.rmse), max(match.rmse)
    comments = [
        f"Clouds like those of {match.target.source}, found by hcss match.",
        *match.target.notes,
        f"RMSE of eq 24 of the HCSS paper over {len(match.rmse)} seeds not used in the search: "
        f"{match.mean_rmse:.1%} ({best:.1%} to {worst:.1%}).",
        *(f"Not matched: {line}." for line in match.unmatched),
    ]
    return clouds_fragment(match.parameters, match.coverage, match.target.image, cloud_type, comments)


def clouds_fragment(
    parameters: FractalParameters, coverage: float, image: CloudImage, cloud_type: str, comments: list[str]
) -> str:
    """Return the section ``[clouds]`` with complete parameters, validated at the size of ``image``, below comments."""
    rows, columns = image.level.shape
    lines: list[str] = []
    for comment in (
        *comments,
        f"Evaluated with: image = {{rows = {rows}, columns = {columns}, pixel_size = {image.pixel_size_m:g}}}",
        f"The type {cloud_type} gives height and particles, which grey levels do not determine.",
    ):
        # A comment in TOML must not contain control characters, but a file name may.
        plain = "".join(letter if letter.isprintable() else "?" for letter in comment)
        lines += textwrap.wrap(plain, _WIDTH, initial_indent="# ", subsequent_indent="#   ")
    lines += [
        "",
        "[clouds]",
        f"type = {json.dumps(cloud_type)}",
        f"coverage = {round(coverage, 9)!r}",
        'generator = "fractal"',
        "",
        "[clouds.parameters]",
    ]
    for name, value in parameters.model_dump().items():
        lines.append(f"{name} = {list(value) if isinstance(value, tuple) else value!r}")
    return "\n".join(lines) + "\n"


def write_fragment(text: str, path: Path) -> None:
    """Write a fragment atomically.

    Raises CatalogError if the file cannot be written.
    """
    with Writing(path, CatalogError, "TOML") as draft:
        draft.write_text(text, encoding="utf-8")
