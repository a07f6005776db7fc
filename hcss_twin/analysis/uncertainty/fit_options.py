"""How to fit.

What is free in a fit, and the priors of what is not told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from hcss_twin.analysis.uncertainty.priors import Prior
from hcss_twin.analysis.uncertainty.space import KINDS, Space
from hcss_twin.core.errors import PosteriorOptionError
from hcss_twin.models.clouds.fractal.octaves import REFERENCE_LENGTH_M


@dataclass(frozen=True)
class FitOptions:
    """How to fit.

    Attributes
    ----------
    fixed : mapping of str to float or "image"
        Parameters among H, gamma, Lx, Ly (cells per 16 km), coverage that are not free. Coverage may be fixed at
        "image": scenes are to have exactly the image's.
    priors : mapping of str to str
        ``kind:number:number`` for parameters, and for ``spread_NAME`` of several images; the others have
        the usual ones.
    octaves : (int, int)
        First and last octave.
    smallest_lag : int
        Pixels; shorter ones are not looked at (blurred or noisy images).
    misfit : float
        Standard deviation of ln semivariance, independent at each lag, by which real clouds are allowed to
        differ from any fractal field.
    seed : int
        Of simulations and chains.
    samples : float
        Effective sample size that every parameter must have.
    most_steps : int
        Limit of steps per walker.
    """

    fixed: Mapping[str, float | Literal["image"]] = field(default_factory=dict)
    priors: Mapping[str, str] = field(default_factory=dict)
    octaves: tuple[int, int] = (0, 8)
    smallest_lag: int = 1
    misfit: float = 0.0
    seed: int = 0
    samples: float = 1000.0
    most_steps: int = 50_000

    def check(self) -> None:
        """Check the numbers.

        Raises
        ------
        PosteriorOptionError
            If one is not allowed.
        """
        first, last = self.octaves
        for name, value, is_allowed, allowed in (
            ("octaves", self.octaves, 0 <= first <= last <= 16, "0 <= first <= last <= 16"),
            ("smallest_lag", self.smallest_lag, self.smallest_lag >= 1, "1 or more pixels"),
            ("misfit", self.misfit, 0.0 <= self.misfit <= 2.0, "0 to 2"),
            ("seed", self.seed, 0 <= self.seed < 2**63, "0 or more"),
            ("samples", self.samples, 100.0 <= self.samples <= 1e6, "100 to 1000000"),
            ("most_steps", self.most_steps, 500 <= self.most_steps <= 10**7, "500 to 10000000"),
        ):
            if not is_allowed:
                raise PosteriorOptionError(f"{name}: {value} given, allowed: {allowed}")


SPREAD = "spread_"

# Cells per frame that the priors of L allow: from one to one of so many pixels.
_SMALLEST_CELL_PIXELS = 4

_USUAL = {"H": "uniform:0.02:0.98", "gamma": "loguniform:1.5:4", "coverage": "uniform:0.01:0.99"}

# Of a population's spread, the least by default.
_MIN_SPREAD = 0.01


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
            raise PosteriorOptionError(f"prior of {SPREAD}{next(iter(given))}: one image has no spread; leave it out")
        return ()
    for name in given:
        if name not in space.names:
            raise PosteriorOptionError(f"prior of {SPREAD}{name}: {name} is not free; leave it out")
    return tuple(
        Prior.parse(
            f"{SPREAD}{name}", given.get(name, f"uniform:{_MIN_SPREAD}:{KINDS[name].widest}"), 0.0, float("inf")
        )
        for name in space.names
    )
