"""Azimuth modes of the BRDF of the sea, and of clouds below others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.providers import SeaModel

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
        return ReflectionModes(*(np.tile(each, columns) for each in (self.view, self.sun, self.between)))

    def rows(self) -> Iterator[Array]:
        """Yield ``between`` for one stream after the other, (M, N, V)."""
        yield from np.moveaxis(self.between, 1, 0)


def unlit_sea_modes(sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections, modes: int) -> ReflectionModes:
    """Return the modes of a sea model's BRDF from 1 to ``modes`` - 1; those of the sun are 0."""
    streams = directions.streams.mu
    count = streams.size
    first, second = (each.ravel() for each in np.meshgrid(streams, streams, indexing="ij"))
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
