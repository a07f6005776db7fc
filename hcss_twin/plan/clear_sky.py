"""Clear sky without texture: all that scenes without texture import of it.

What a texture adds, its fields and the polynomials between its states, is in :mod:`hcss_twin.plan.texture`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.combinations import NotComputed
from hcss_twin.plan.effects import Effect
from hcss_twin.scenario.scenario import Scenario

STEP = 3.0**0.5
"""Perturbation of the tables in standard deviations: with 0, a node of Gaussian quadrature of a normal distribution."""

State: TypeAlias = tuple[float, float]
"""Perturbation in steps: of the sea toward warm, of the vapour toward dry."""


@dataclass(frozen=True)
class VapourNodes:
    """Perturbations of the vapour with tables; a polynomial joins those of each segment, and the scene itself, at 0.

    Attributes
    ----------
    segments : tuple of tuple of float
        Places of the nodes of each segment, in steps toward dry air, the moistest segment first.
    kinks : tuple of float
        Where one segment ends and the next begins, ascending: radiance has kinks there.
    """

    segments: tuple[tuple[float, ...], ...]
    kinks: tuple[float, ...] = ()

    @property
    def places(self) -> tuple[float, ...]:
        """Places of all nodes but the scene itself, each once."""
        return tuple(dict.fromkeys(place for segment in self.segments for place in segment if place))


PARABOLA = VapourNodes(((0.0, 1.0, -1.0),))


class EvenFields:
    """Fields without texture."""

    def at(self, time_s: float, rows: slice, columns: slice) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return how far pixels (y, x) are perturbed, in steps toward warm sea and toward dry air."""
        shape = rows.stop - rows.start, columns.stop - columns.start
        return np.zeros(shape, np.float32), np.zeros(shape, np.float32)


@dataclass(frozen=True)
class EvenSky(Effect):
    """Clear sky that is the same everywhere; the base of :class:`.texture.Texture`.

    Attributes
    ----------
    temperature_K : float
        Standard deviation of the sea's temperature.
    water_vapour : float
        That of the vapour at all levels, relative.
    vapour_share : float
        Share of the latter within the image, which has no longer wavelengths than itself.
    vapour : VapourNodes
        Amounts of vapour with tables.
    """

    kind = "texture"
    varies = False

    temperature_K: float = 0.0
    water_vapour: float = 0.0
    vapour_share: float = 1.0
    vapour: VapourNodes = PARABOLA

    @property
    def steps(self) -> tuple[float, float]:
        """Perturbation of the tables: K, and share of the vapour."""
        return STEP * self.temperature_K, STEP * self.water_vapour * self.vapour_share

    @property
    def changes_sunlight(self) -> bool:
        """Whether the sunlight that reaches the sensor from the sea differs between pixels: with their vapour."""
        return self.water_vapour > 0.0

    @property
    def expansion_states(self) -> Sequence[State]:
        """States between which the certificate interpolates."""
        return ()

    def without_flat(self, state: State) -> State:
        """Return a state without what has no texture."""
        return state[0] * (self.temperature_K > 0.0), state[1] * (self.water_vapour > 0.0)

    def sea_is_proportional(self, assembly: Assembly) -> bool:
        """Whether columns over a warmer sea follow from those of the scene.

        Models of other packages may have one term for sea and clouds.
        """
        return self.temperature_K > 0.0 and assembly.entries["radiance"].is_own

    def perturbed(self, assembly: Assembly, state: State) -> Assembly:
        """Return the scene in a perturbed state everywhere."""
        warmer_K, drier = (change * step for change, step in zip(state, self.steps, strict=True))
        return assembly.perturbed(warmer_K, 1.0 - drier)

    def with_own_spectra(self, assembly: Assembly) -> list[Assembly]:
        """Return the scene in the states whose differences from it need wavenumbers of their own."""
        return []

    def fields(self, scenario: Scenario, assembly: Assembly) -> EvenFields:
        """Return the fields of the scene."""
        return EvenFields()

    def change_between(
        self, values: Array, warmer: NDArray[np.float32], drier: NDArray[np.float32]
    ) -> tuple[Array, Array]:
        """Return how values (S, ...) in the states of the tables change in pixels (y, x).

        Returns
        -------
        change : ndarray (..., y or 1, x or 1)
        by_sea : ndarray (2, ...)
            What each step of ``warmer`` and of its square adds.
        """
        return np.zeros((*values.shape[1:], 1, 1)), np.zeros((2, *values.shape[1:]))

    def change(self, perturbation: Array, in_states: Callable[[], Array]) -> Array | float:
        """Return how quantities (N, Q, B) change at perturbations (N, 2).

        Parameters
        ----------
        in_states : callable
            Computes them (S, N, Q, B) at :attr:`.texture.Texture.expansion_states`; not called without texture.
        """
        return 0.0


EVEN_SKY = EvenSky()

EVEN_VAPOUR = NotComputed(
    "atmosphere.water_vapour_texture is 0", "atmosphere.water_vapour_texture = 0.05", switched_off=True
)
