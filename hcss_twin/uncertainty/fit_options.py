"""How to fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from hcss_twin.errors import PosteriorOptionError


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
