"""The sea as an interface: emission, reflection of sky radiance by streams, glint, and azimuth modes of reflection."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.providers import SeaModel

MAX_DEFECT = 0.1
"""Maximum difference between the integral of a BRDF and 1 - emissivity."""

_COSINES, _AZIMUTHS = 64, 48


@dataclass(frozen=True)
class SeaSurface:
    """Emissivity and reflection of the sea, which sum to one in each of D directions: the view, and mostly the streams.

    Attributes
    ----------
    emissivity : ndarray (D, V)
        Toward the view and the streams.
    reflection : ndarray (D, N, V)
        Contribution of each stream's downwelling radiance to the radiance toward a direction.
    sun : ndarray (D, V)
        BRDF in sr-1 for sunlight: at the view azimuth toward the view, as azimuth mean toward streams; 0 without a sun.
    """

    emissivity: Array
    reflection: Array
    sun: Array

    def repeated(self, columns: int) -> SeaSurface:
        """Return the sea repeated for C columns, (..., C x V)."""
        if columns == 1:
            return self
        return replace(
            self,
            emissivity=np.tile(self.emissivity, columns),
            reflection=np.tile(self.reflection, columns),
            sun=np.tile(self.sun, columns),
        )


def sunlit(surface: SeaSurface, sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections) -> SeaSurface:
    """Return a surface with the sunlight that it reflects for the sun of ``directions``."""
    return replace(surface, sun=_sunlight(sea, wavenumber_cm1, directions, len(surface.sun)))


def unlit_sea_surface(
    sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections, *, view_only: bool = False
) -> SeaSurface:
    """Return emission and sky reflection of a sea model, independent of the sun; sunlight is 0.

    With ``view_only``, they are those toward the view (D = 1): nothing else is seen where no cloud reflects light.

    A provider may have ``reflection_weights(wavenumber_cm1, mu, mu_nodes) -> (M, N, V)``, the fraction of the light in
    each direction that comes from the sky at each node. Otherwise its BRDF is integrated over a fine grid of directions
    that is folded onto the streams.

    Raises
    ------
    ProviderError
        If the emissivity and integrated BRDF of a provider do not sum to one within 0.1.
    """
    reflection_weights = getattr(sea, "reflection_weights", None)
    wind = _wind(sea, directions)
    mu = directions.mu[: VIEW + 1] if view_only else directions.mu
    # Only the view has an azimuth relative to the wind; streams are azimuth means.
    others = slice(VIEW + 1, None) if wind else slice(None)
    together = mu[others].size > 0
    weights = np.empty((mu.size, directions.count, wavenumber_cm1.size))
    if reflection_weights is not None:
        # Called before the emissivity, which some providers then have in memory.
        if together:
            weights[others] = reflection_weights(wavenumber_cm1, mu[others], directions.streams.mu)
        if wind:
            weights[VIEW] = reflection_weights(wavenumber_cm1, mu[VIEW : VIEW + 1], directions.streams.mu, **wind)[0]
    emissivity = np.empty((mu.size, wavenumber_cm1.size))
    if together:
        emissivity[others] = sea.emissivity(wavenumber_cm1, mu[others])
    if wind:
        emissivity[VIEW] = sea.emissivity(wavenumber_cm1, mu[VIEW : VIEW + 1], **wind)[0]
    left = np.maximum(1.0 - emissivity, 0.0)
    if reflection_weights is None:
        weights = _integrated(sea, wavenumber_cm1, mu, directions.streams.mu)
        defect = float(np.max(np.abs(emissivity[0] + weights[0].sum(axis=0) - 1.0)))
        if defect > MAX_DEFECT:
            raise ProviderError(
                f"sea: emissivity and integrated BRDF sum to 1 +- {defect:.3g} toward the view; allowed 1 +- "
                f"{MAX_DEFECT:g}"
            )
    total = weights.sum(axis=1)
    nothing = total <= 0.0
    # If the BRDF is 0 everywhere, it cannot be scaled: all light comes from the mirror direction.
    if np.any(nothing & (left > 0.0)):
        nearest = np.argmin(np.abs(mu[:, None] - directions.streams.mu), axis=1)
        for row, node in enumerate(nearest):
            weights[row, node] = np.where(nothing[row], 1.0, weights[row, node])
        total = weights.sum(axis=1)
    weights = weights * (left / np.where(total > 0.0, total, 1.0))[:, None, :]
    return SeaSurface(emissivity, weights, np.zeros_like(emissivity))


def _integrated(sea: SeaModel, wavenumber_cm1: Array, toward: Array, streams: Array) -> Array:
    """Integrate BRDF x cosine over the sky onto the streams (N,) with linear weights, (D, N, V)."""
    nodes, node_weights = np.polynomial.legendre.leggauss(_COSINES)
    mu_in, d_mu = 0.5 * (nodes + 1.0), 0.5 * node_weights
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS
    onto = hats(mu_in, streams)
    result = np.empty((toward.size, streams.size, wavenumber_cm1.size))
    for row, mu in enumerate(toward):
        into, turn = (angles.ravel() for angles in np.meshgrid(mu_in, azimuth, indexing="ij"))
        brdf = sea.brdf(wavenumber_cm1, np.full(into.size, mu), into, turn)
        mean = brdf.reshape(_COSINES, _AZIMUTHS, -1).mean(axis=1)
        result[row] = onto.T @ (2.0 * np.pi * (mu_in * d_mu)[:, None] * mean)
    return result


def hats(mu: Array, nodes: Array) -> Array:
    """Return linear interpolation weights (M, N) of ``mu`` between ascending or descending ``nodes``."""
    order = np.argsort(nodes)
    position = np.interp(mu, nodes[order], np.arange(nodes.size, dtype=np.float64))
    low = np.minimum(position.astype(np.int64), nodes.size - 2)
    weights = np.zeros((mu.size, nodes.size))
    rows = np.arange(mu.size)
    weights[rows, order[low]] = 1.0 - (position - low)
    weights[rows, order[low + 1]] += position - low
    return weights


def _sunlight(sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections, count: int) -> Array:
    """Return the BRDF (D, V) for sunlight toward the first directions."""
    result = np.zeros((count, wavenumber_cm1.size))
    if directions.sun is None:
        return result
    one = np.ones(1)
    result[VIEW] = sea.brdf(
        wavenumber_cm1,
        directions.mu[VIEW] * one,
        directions.mu_sun * one,
        directions.relative_azimuth * one,
        **_wind(sea, directions),
    )[0]
    if count == 1:
        return result
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * np.pi / _AZIMUTHS
    streams = directions.streams.mu
    many, turn = np.repeat(streams, azimuth.size), np.tile(azimuth, streams.size)
    brdf = sea.brdf(wavenumber_cm1, many, np.full(many.size, directions.mu_sun), turn)
    result[list(directions.stream_indices)] = brdf.reshape(streams.size, azimuth.size, -1).mean(axis=1)
    return result


def _wind(sea: SeaModel, directions: ColumnDirections) -> dict[str, Array]:
    """Return the view azimuth relative to the wind for a sea that depends on it; streams get the azimuth mean."""
    return {"wind_azimuth": np.array([directions.wind_azimuth])} if getattr(sea, "anisotropic", False) else {}


_LEAST_AZIMUTHS, _MORE_AZIMUTHS = 32, 16
"""Azimuths of the BRDF: at least so many, and so many more than modes (N azimuths confuse mode m with 2 N - m)."""


@dataclass(frozen=True)
class ReflectionModes:
    """Azimuth modes of a BRDF, sr-1: from 0 on of a cloud, from 1 on of the sea, averaged over wind directions.

    Attributes
    ----------
    view : ndarray (M, N, V)
        Toward the view from the streams.
    sun : ndarray (M, N, V)
        Toward the streams from the sun.
    between : ndarray (M, N, N, V)
        Toward streams (first) from streams.
    """

    view: Array
    sun: Array
    between: Array

    def repeated(self, columns: int) -> ReflectionModes:
        """Return the modes of the sea repeated for C columns, (..., C x V)."""
        if columns == 1:
            return self
        return ReflectionModes(*(np.tile(modes, columns) for modes in (self.view, self.sun, self.between)))

    def rows(self) -> Iterator[Array]:
        """Yield ``between`` for one stream after the other, (M, N, V)."""
        yield from np.moveaxis(self.between, 1, 0)


def unlit_sea_modes(sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections, modes: int) -> ReflectionModes:
    """Return the modes of a sea model's BRDF from 1 to ``modes`` - 1; those of the sun are 0."""
    streams = directions.streams.mu
    count = streams.size
    first, second = (cosines.ravel() for cosines in np.meshgrid(streams, streams, indexing="ij"))
    between = expanded(sea, wavenumber_cm1, first, second, modes)[1:]
    view = expanded(sea, wavenumber_cm1, np.full(count, directions.mu[VIEW]), streams, modes)[1:]
    return ReflectionModes(view, np.zeros_like(view), between.reshape(modes - 1, count, count, -1))


def sunlit_modes(
    unlit: ReflectionModes, sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections
) -> ReflectionModes:
    """Return the modes, completed for the sun of ``directions``."""
    streams = directions.streams.mu
    toward_sun = np.full(streams.size, directions.mu_sun)
    sun = expanded(sea, wavenumber_cm1, streams, toward_sun, unlit.view.shape[0] + 1)[1:]
    return replace(unlit, sun=sun)


def expanded(
    sea: SeaModel, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, modes: int, resolved: int | None = None
) -> Array:
    """Return the modes (M, P, V), from 0 on, of a sea BRDF for pairs of directions (P,).

    With ``resolved``, they are those of as many modes: near the horizon, azimuths do not resolve glints.
    """
    azimuths = max(_LEAST_AZIMUTHS, (resolved or modes) + _MORE_AZIMUTHS)
    azimuth = (np.arange(azimuths) + 0.5) * np.pi / azimuths
    cosine = np.cos(np.arange(modes)[:, None] * azimuth) / azimuths
    many = mu_out.size
    brdf = sea.brdf(wavenumber_cm1, np.repeat(mu_out, azimuths), np.repeat(mu_in, azimuths), np.tile(azimuth, many))
    result: Array = np.einsum("ma,pav->mpv", cosine, brdf.reshape(many, azimuths, -1))
    return result
