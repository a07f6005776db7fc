"""Standard deviations of clear-sky texture, and clear sky without: what scenes without texture import, too.

The fields and the polynomials of texture are in :mod:`hcss_twin.plan.texture`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.effects import Effect
from hcss_twin.scenario.scenario import Scenario

STEP = 3.0**0.5
"""Perturbation of the tables in standard deviations: with 0, a node of Gaussian quadrature of a normal distribution."""

State: TypeAlias = tuple[float, float]
"""Perturbation in steps: of the sea toward warm, of the vapour toward dry."""

OWN_SPECTRA: Sequence[State] = ((1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""States whose spectra tell which wavenumbers their difference from the scene needs."""


class EvenFields:
    """Fields without texture."""

    def at(self, time_s: float, rows: slice, columns: slice) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return how far pixels (y, x) are perturbed, in steps toward warm sea and toward dry air."""
        shape = rows.stop - rows.start, columns.stop - columns.start
        return np.zeros(shape, np.float32), np.zeros(shape, np.float32)


@dataclass(frozen=True)
class Texture(Effect):
    """Standard deviations of a scene's clear-sky texture; at least one is above 0.

    Attributes
    ----------
    temperature_K : float
        Of the sea.
    water_vapour : float
        Relative, of the vapour at all levels.
    """

    kind = "texture"

    temperature_K: float
    water_vapour: float

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return the deviations; those of a small image are others."""
        return {"texture": astuple(self)}

    @property
    def steps(self) -> tuple[float, float]:
        """Perturbation of the tables: K, and share of the vapour."""
        return STEP * self.temperature_K, STEP * self.water_vapour

    def without_flat(self, state: State) -> State:
        """Return a state without what has no texture."""
        return state[0] * (self.temperature_K > 0.0), state[1] * (self.water_vapour > 0.0)

    def sea_is_proportional(self, assembly: Assembly) -> bool:
        """Whether :func:`.texture.sea_factors` hold in cloud: models of other packages may not tell sea from clouds."""
        return self.temperature_K > 0.0 and assembly.entries["radiance"].is_own

    def perturbed(self, assembly: Assembly, state: State) -> Assembly:
        """Return the scene in a perturbed state everywhere."""
        warmer_K, drier = (change * step for change, step in zip(state, self.steps, strict=True))
        return assembly.perturbed(warmer_K, 1.0 - drier)

    def with_own_spectra(self, assembly: Assembly) -> list[Assembly]:
        """Return the scene in the states whose differences from it need wavenumbers of their own."""
        if self.water_vapour == 0.0 and self.sea_is_proportional(assembly):
            return []
        return [self.perturbed(assembly, state) for state in OWN_SPECTRA]

    def fields(self, scenario: Scenario, assembly: Assembly) -> EvenFields:
        """Return the fields of the scene."""
        from hcss_twin.plan.texture import TextureFields  # not for scenes without texture

        return TextureFields(scenario, assembly, self)

    def change(self, perturbation: Array, in_states: Callable[[], Array]) -> Array | float:
        """Return how values (N, ...) change at perturbations (N, 2).

        Parameters
        ----------
        in_states : callable
            Computes the values (9, N, ...) at :data:`.texture.EXPANSION_STATES`; not called without texture.
        """
        from hcss_twin.plan.texture import Expansion  # not for scenes without texture

        values = in_states()
        warmer, drier = perturbation.T.reshape(2, -1, *(1,) * (values.ndim - 2))
        return Expansion(values)(warmer, drier)


class EvenSky(Texture):
    """Clear sky that is the same everywhere."""

    varies = False

    def with_own_spectra(self, assembly: Assembly) -> list[Assembly]:
        """Return no scene: nothing is perturbed."""
        return []

    def fields(self, scenario: Scenario, assembly: Assembly) -> EvenFields:
        """Return fields of zeros."""
        return EvenFields()

    def change(self, perturbation: Array, in_states: Callable[[], Array]) -> Array | float:
        """Return 0."""
        return 0.0


EVEN_SKY = EvenSky(0.0, 0.0)
