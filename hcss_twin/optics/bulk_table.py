"""Bulk properties of one size distribution of spheres, tabulated over wavelength.

Nothing but wavelength is interpolated. Everything that a value depends on enters the table's key, so that tables can
be kept in files and found again by content.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.optics.bulk import bulk_moments, bulk_properties
from hcss_twin.optics.size_distribution import check
from hcss_twin.optics.spectral_panels import PanelTable, panel_edges
from hcss_twin.providers import Microphysics
from hcss_twin.refractive_index import RefractiveIndex

Array = NDArray[np.float64]
Progress = Callable[[Iterable[NDArray[np.intp]], int], Iterator[NDArray[np.intp]]]
"""Wraps an iteration over pieces of work, whose sizes add up to the number given."""

VALID_UM = (0.3, 16.0)
"""Wavelengths inside which the errors of quadrature and interpolation were measured."""

COMPUTATION = 1
"""Version of the computation; raised whenever the same input gives other numbers."""

_MOMENT_STEP = 2.0
"""Widest panel of the moments, in widest panels of the other properties: they vary less."""

_NODES_AT_ONCE = 16


@dataclass(frozen=True)
class Accuracy:
    """How finely a table is computed.

    Attributes
    ----------
    radius_nodes : int
        Radii of the quadrature over sizes.
    spectral_step : float
        Widest panel over ln wavelength.
    moments : int
        Legendre moments of the phase function; 2 leaves only the asymmetry parameter.
    """

    radius_nodes: int
    spectral_step: float
    moments: int


class BulkTable:
    """Extinction, absorption, asymmetry and moments per particle over ln wavelength (um).

    Parameters
    ----------
    cloud : Microphysics
        Particles; their number density has no influence.
    index : RefractiveIndex
        Of their substance.
    accuracy : Accuracy
        Fineness.

    Raises
    ------
    ValueError
        If the particles' parameters are not valid, or the refractive index has no wavelength in ``VALID_UM``.
    """

    def __init__(self, cloud: Microphysics, index: RefractiveIndex, accuracy: Accuracy) -> None:
        self._cloud = replace(cloud, number_density_m3=1.0)
        check(self._cloud)
        self._index = index
        self._accuracy = accuracy
        kinks = np.log(np.unique(np.clip(index.wavelength_um, *VALID_UM)))
        if kinks.size < 2:
            raise ValueError(f"refractive index '{index.name}' covers no wavelength of {VALID_UM} um")
        step = accuracy.spectral_step
        self.properties = PanelTable(panel_edges(kinks, step), components=3)
        self.moments = PanelTable(panel_edges(kinks, _MOMENT_STEP * step), components=accuracy.moments)
        self.key = self._key()

    def _key(self) -> str:
        particles = asdict(self._cloud)
        del (
            particles["number_density_m3"],
            particles["phase"],
        )  # the refractive index says what they are made of
        text = json.dumps([COMPUTATION, VALID_UM, particles, asdict(self._accuracy)], sort_keys=True)
        digest = hashlib.sha256(text.encode())
        for column in (self._index.wavelength_um, self._index.n, self._index.k):
            digest.update(np.ascontiguousarray(column, dtype="<f8").tobytes())
        return digest.hexdigest()

    @property
    def has_moments(self) -> bool:
        """Whether the phase function has moments of its own."""
        return self._accuracy.moments > 2

    def __call__(self, position: Array) -> tuple[Array, Array, Array, Array]:
        """Cross sections of extinction and absorption per particle (V,), m2, asymmetry (V,) and moments (K, V).

        All nodes that ``position`` (V,), ln wavelength in um, needs must have values.
        """
        log_extinction, log_absorption, asymmetry = self.properties(position)
        moments = self.moments(position) if self.has_moments else np.empty((2, position.size))
        # Radii and panels are finer for the asymmetry than for the moments, where the two differ at all.
        moments[0], moments[1] = 1.0, asymmetry
        return np.exp(log_extinction), np.exp(log_absorption), asymmetry, moments

    def complete(self, position: Array, progress: Progress) -> bool:
        """Compute what ``position`` (V,) needs and is not yet known; True if there was anything to compute."""
        wanted = self.properties.missing(position)
        wanted_moments = self.moments.missing(position) if self.has_moments else np.empty(0, dtype=np.intp)
        pieces = [(self.properties, part, self._properties) for part in _pieces(wanted)]
        pieces += [(self.moments, part, self._moments) for part in _pieces(wanted_moments)]
        total = wanted.size + wanted_moments.size
        if not total:
            return False
        work = iter(pieces)
        for nodes in progress([part for _, part, _ in pieces], total):
            table, _, evaluate = next(work)
            table.fill(nodes, evaluate)
        return True

    def _properties(self, position: Array) -> Array:
        bulk = bulk_properties(self._cloud, self._index, np.exp(position), self._accuracy.radius_nodes)
        return np.stack([np.log(bulk.extinction_m1), np.log(bulk.absorption_m1), bulk.asymmetry])

    def _moments(self, position: Array) -> Array:
        accuracy = self._accuracy
        moments = bulk_moments(
            self._cloud, self._index, np.exp(position), accuracy.radius_nodes, accuracy.moments
        )
        # As files keep them, so that a result does not depend on where its table came from.
        return moments.astype(np.float32).astype(np.float64)


def _pieces(nodes: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    return [nodes[start : start + _NODES_AT_ONCE] for start in range(0, nodes.size, _NODES_AT_ONCE)]
