"""What is free in a fit, and the priors of what is not told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hcss_twin.clouds.fractal.octaves import REFERENCE_LENGTH_M
from hcss_twin.errors import PosteriorOptionError
from hcss_twin.uncertainty.fit_options import FitOptions
from hcss_twin.uncertainty.priors import Prior
from hcss_twin.uncertainty.scales import KINDS
from hcss_twin.uncertainty.space import Space

SPREAD = "spread_"

# Cells per frame that the priors of L allow: from one to one of so many pixels.
_SMALLEST_CELL_PIXELS = 4

_USUAL = {"H": "uniform:0.02:0.98", "gamma": "loguniform:1.5:4", "coverage": "uniform:0.01:0.99"}

# Of a population's spread, the least by default.
_LEAST_SPREAD = 0.01


def space_of(
    options: FitOptions, coverage: float, frames: Sequence[tuple[int, int, float]], *, several: bool
) -> tuple[Space, tuple[Prior, ...]]:
    """Return what is free, and the priors of spreads, for images of this coverage and these frames.

    Raises
    ------
    PosteriorOptionError
        If a parameter is fixed at a word, or a prior is not allowed.
    """
    fixed = dict(options.fixed)
    if fixed.get("coverage") == "image":
        fixed["coverage"] = coverage
    numbers = {name: fixed_number(name, value) for name, value in fixed.items()}
    own = {name: text for name, text in options.priors.items() if not name.startswith(SPREAD)}
    space = Space.of(numbers, own, usual_priors(frames))
    return space, _spread_priors(space, options.priors, several)


def fixed_number(name: str, value: float | str) -> float:
    """Return what a parameter is fixed at.

    Raises
    ------
    PosteriorOptionError
        If it is a word.
    """
    if isinstance(value, str):
        where = "a number, or 'image' of images" if name == "coverage" else "a number"
        raise PosteriorOptionError(f"{name}: fixed at '{value}', allowed: {where}")
    return float(value)


def usual_priors(frames: Sequence[tuple[int, int, float]]) -> dict[str, str]:
    """Return the priors of what is not given, for frames of rows, columns and pixel size."""
    usual = dict(_USUAL)
    for name, axis in (("Lx", 1), ("Ly", 0)):
        low = min(REFERENCE_LENGTH_M / (frame[axis] * frame[2]) for frame in frames)
        high = max(REFERENCE_LENGTH_M / (_SMALLEST_CELL_PIXELS * frame[2]) for frame in frames)
        usual[name] = f"loguniform:{low:.6g}:{high:.6g}"
    return usual


def _spread_priors(space: Space, priors: Mapping[str, str], several: bool) -> tuple[Prior, ...]:
    given = {name.removeprefix(SPREAD): text for name, text in priors.items() if name.startswith(SPREAD)}
    if not several:
        if given:
            raise PosteriorOptionError(
                f"prior of {SPREAD}{next(iter(given))}: one image has no spread; leave it out"
            )
        return ()
    for name in given:
        if name not in space.names:
            raise PosteriorOptionError(f"prior of {SPREAD}{name}: {name} is not free; leave it out")
    return tuple(
        Prior.parse(
            f"{SPREAD}{name}",
            given.get(name, f"uniform:{_LEAST_SPREAD}:{KINDS[name].widest}"),
            0.0,
            float("inf"),
        )
        for name in space.names
    )
