"""Bulk optical properties of particles: Mie efficiencies integrated over sizes and tabulated over wavelength.

Tables are interpolated only in wavelength, piecewise quadratically. Panels end at the rows of the refractive-index
table, where bulk properties have kinks, and are subdivided to a maximum relative step. Nodes depend only on the table,
so that the value at a wavenumber does not depend on which others are requested; they are computed when first needed.
The table key contains everything that a value depends on, so that tables can be stored in files and found by content.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.optics.size_distribution import check, quadrature
from hcss_twin.models.optics.spheres import MomentSums, mie_efficiencies
from hcss_twin.models.refractive_index import RefractiveIndex
from hcss_twin.providers import Microphysics

RESONANCES = ((0.0015, 16), (0.005, 8), (0.02, 4), (np.inf, 1))
"""Imaginary index below which the number of radii is multiplied: weak absorption makes resonances narrow."""

_SPHERES_AT_ONCE = 65536

MAX_MOMENT_RADII = 2
"""Maximum multiple of the radii for the phase function, whose resonances average out over wavelengths."""


@dataclass(frozen=True, eq=False)
class BulkProperties:
    """Coefficients of a cloud volume.

    Attributes
    ----------
    extinction_m1, scattering_m1 : ndarray (V,)
        Volume coefficients, m-1.
    asymmetry : ndarray (V,)
        Scattering-weighted asymmetry parameter.
    """

    extinction_m1: Array
    scattering_m1: Array
    asymmetry: Array

    @property
    def absorption_m1(self) -> Array:
        """Volume absorption coefficient (V,), m-1."""
        return self.extinction_m1 - self.scattering_m1

    @property
    def albedo(self) -> Array:
        """Single-scattering albedo (V,) (HCSS paper, eq 11)."""
        return self.scattering_m1 / self.extinction_m1


def bulk_properties(
    cloud: Microphysics, index: RefractiveIndex, wavelength_um: Array, radius_nodes: int
) -> BulkProperties:
    """Integrate Mie efficiencies over the particles at each wavelength, without spectral interpolation.

    Parameters
    ----------
    cloud : Microphysics
        Particles, with a number density above 0.
    index : RefractiveIndex
        Of their substance.
    wavelength_um : ndarray (V,)
        Wavelengths within the range of ``index``.
    radius_nodes : int
        Number of radii in the quadrature; more if k is small, see ``RESONANCES``.

    Returns
    -------
    BulkProperties
        For ``wavelength_um`` (V,).

    Notes
    -----
    HCSS paper, eq 9: pi * integral of r^2 Q n(r) dr, for absorption and extinction alike. The paper's eq 10 for ice
    multiplies 1 - albedo by an efficiency alone; a coefficient per length also needs the number density, so ice is
    integrated as in eq 9.
    """
    wavelength = np.asarray(wavelength_um, dtype=np.float64)
    refractive = index.at(1e4 / wavelength)
    factor = _radius_multiple(refractive)
    sums = np.empty((3, wavelength.size))
    for many in np.unique(factor):
        chosen = factor == many
        sums[:, chosen] = _integrate(cloud, refractive[chosen], wavelength[chosen], int(many) * radius_nodes)
    extinction, scattering, forward = sums
    return BulkProperties(extinction, scattering, forward / scattering)


def bulk_moments(
    cloud: Microphysics, index: RefractiveIndex, wavelength_um: Array, radius_nodes: int, count: int
) -> Array:
    """Compute Legendre moments of the bulk phase function, without spectral interpolation.

    Parameters
    ----------
    cloud, index, wavelength_um, radius_nodes
        As for :func:`bulk_properties`; the number of radii is multiplied by at most ``MAX_MOMENT_RADII``.
    count : int
        Number K of moments.

    Returns
    -------
    ndarray (K, V)
        ``moments[0]`` is 1 and ``moments[1]`` is the asymmetry parameter.
    """
    wavelength = np.asarray(wavelength_um, dtype=np.float64)
    refractive = index.at(1e4 / wavelength)
    sums = MomentSums(count)
    result = np.empty((count, wavelength.size))
    for column, many in enumerate(np.minimum(_radius_multiple(refractive), MAX_MOMENT_RADII)):
        radius, number = quadrature(cloud, int(many) * radius_nodes)
        size = 2.0 * np.pi * radius / wavelength[column]
        result[:, column] = sums(complex(refractive[column]), size, number)
    return result


def _radius_multiple(refractive: NDArray[np.complex128]) -> NDArray[np.int64]:
    """Return the multiple of the number of radii for each wavelength (V,)."""
    below = [refractive.imag < limit for limit, _ in RESONANCES]
    return np.asarray(np.select(below, [many for _, many in RESONANCES]), dtype=np.int64)


def _integrate(cloud: Microphysics, refractive: NDArray[np.complex128], wavelength_um: Array, nodes: int) -> Array:
    """Return extinction, scattering and asymmetry-weighted scattering coefficients (3, V), m-1."""
    radius, number = quadrature(cloud, nodes)
    area = np.pi * (radius * 1e-6) ** 2 * number
    result = np.empty((3, wavelength_um.size))
    step = max(1, _SPHERES_AT_ONCE // radius.size)
    for start in range(0, wavelength_um.size, step):
        part = slice(start, start + step)
        size = 2.0 * np.pi * radius / wavelength_um[part, np.newaxis]
        substance = np.broadcast_to(refractive[part, np.newaxis], size.shape)
        q_ext, q_sca, g = (q.reshape(size.shape) for q in mie_efficiencies(substance.ravel(), size.ravel()))
        result[:, part] = q_ext @ area, q_sca @ area, (q_sca * g) @ area
    return result


def panel_edges(kinks: Array, step: float) -> Array:
    """Split the intervals between ``kinks`` (T,), ascending ln wavelengths, into panels of at most ``step``.

    Returns
    -------
    ndarray (P + 1,)
        Panel edges, ascending, including all kinks.
    """
    width = np.diff(kinks)
    pieces = np.maximum(np.ceil(width / step), 1.0).astype(np.intp)
    number = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.append(number * np.repeat(width / pieces, pieces) + np.repeat(kinks[:-1], pieces), kinks[-1])


class PanelTable:
    """Interpolation table of functions with values at nodes.

    Parameters
    ----------
    edges : ndarray (P + 1,)
        Edges of the panels, ascending.
    components : int
        Number C of functions.

    Attributes
    ----------
    nodes : ndarray (2 P + 1,)
        Positions: the edges and the middles of the panels.
    values : ndarray (C, 2 P + 1)
        Values at the nodes, NaN where not yet computed.
    """

    def __init__(self, edges: Array, components: int) -> None:
        self.nodes = np.empty(2 * edges.size - 1)
        self.nodes[::2] = edges
        self.nodes[1::2] = 0.5 * (edges[:-1] + edges[1:])
        self.values = np.full((components, self.nodes.size), np.nan)
        self._edges = edges

    def missing(self, position: Array) -> NDArray[np.intp]:
        """Return the nodes (N,) needed for ``position`` (V,) that have no values yet."""
        wanted = np.unique(2 * self._panel(position)[:, np.newaxis] + np.arange(3))
        result: NDArray[np.intp] = wanted[np.isnan(self.values[0, wanted])]
        return result

    def fill(self, nodes: NDArray[np.intp], evaluate: Callable[[Array], Array]) -> None:
        """Set the values of ``nodes`` (N,) from ``evaluate``, which maps positions (N,) to values (C, N)."""
        if nodes.size:
            self.values[:, nodes] = evaluate(self.nodes[nodes])

    def adopt(self, values: Array) -> None:
        """Fill missing values from the values (C, 2 P + 1) of another table at the same nodes."""
        unknown = np.isnan(self.values[0])
        self.values[:, unknown] = values[:, unknown]

    def __call__(self, position: Array) -> Array:
        """Return interpolated values (C, V) at ``position`` (V,), which must be inside the edges and computed."""
        panel = self._panel(position)
        low, high = self._edges[panel], self._edges[panel + 1]
        t = (position - low) / (high - low)
        first, middle, last = (self.values[:, 2 * panel + offset] for offset in range(3))
        result: Array = first * (1.0 - t) * (1.0 - 2.0 * t) + middle * 4.0 * t * (1.0 - t) + last * t * (2.0 * t - 1.0)
        return result

    def _panel(self, position: Array) -> NDArray[np.intp]:
        last = self._edges.size - 2
        return np.clip(np.searchsorted(self._edges, position, side="right") - 1, 0, last)


Progress = Callable[[Iterable[NDArray[np.intp]], int], Iterator[NDArray[np.intp]]]
"""Wraps an iteration over work items, given their total size."""

VALID_UM = (0.3, 16.0)
"""Wavelength range in which quadrature and interpolation errors were measured."""

COMPUTATION = 1
"""Version of the computation; incremented when the same input gives different numbers."""

_MOMENT_STEP = 2.0
"""Ratio of the maximum panel widths of moments and other properties: moments vary less."""

_NODES_AT_ONCE = 16


@dataclass(frozen=True)
class Accuracy:
    """Resolution of a table.

    Attributes
    ----------
    radius_nodes : int
        Radii of the quadrature over sizes.
    spectral_step : float
        Maximum panel width in ln wavelength.
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
        Particles; their number density has no effect.
    index : RefractiveIndex
        Of their substance.
    accuracy : Accuracy
        Resolution of the table.

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
        for name in ("number_density_m3", "material", "density_kg_m3"):  # the refractive index says what they are
            del particles[name]
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
        """Return extinction and absorption cross sections per particle (V,), m2, asymmetry (V,) and moments (K, V).

        All nodes that ``position`` (V,), ln wavelength in um, needs must have values.
        """
        log_extinction, log_absorption, asymmetry = self.properties(position)
        moments = self.moments(position) if self.has_moments else np.empty((2, position.size))
        # Radii and panels are at least as fine for the asymmetry as for the moments.
        moments[0], moments[1] = 1.0, asymmetry
        return np.exp(log_extinction), np.exp(log_absorption), asymmetry, moments

    def complete(self, position: Array, progress: Progress) -> bool:
        """Compute the missing values that ``position`` (V,) needs; return whether there were any."""
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
        moments = bulk_moments(self._cloud, self._index, np.exp(position), accuracy.radius_nodes, accuracy.moments)
        # Single precision as in files, so that a result does not depend on the source of its table.
        return moments.astype(np.float32).astype(np.float64)


def _pieces(nodes: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    return [nodes[start : start + _NODES_AT_ONCE] for start in range(0, nodes.size, _NODES_AT_ONCE)]
