"""Azimuth modes of sunlight between one cloud and the sea: the glint seen through a thin cloud.

Diffuse light along the streams is an azimuth mean. Sunlight scattered forward by a thin cloud is not azimuthally
uniform: it still comes from near the sun, and the sea reflects it into the glint. With the modes T_m of the cloud
transmission and R_m of the sea BRDF, the azimuth mean omits, for one reflection by the sea,

    sum over m of 2 cos(m phi) [t_view R_m(view, k) T_m(k, sun) + T_m(view, j) R_m(j, sun) t_sun
                                + T_m(view, j) R_m(j, k) T_m(k, sun)]

with streams j and k weighted by 2 pi mu w, direct transmissions t, and the air of each path in front of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.directions import VIEW, ColumnDirections
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.providers import SeaModel

_LEAST_AZIMUTHS, _MORE_AZIMUTHS = 32, 16
"""Azimuths of the BRDF: at least so many, and so many more than modes (N azimuths confuse mode m with 2 N - m)."""


@dataclass(frozen=True)
class SeaModes:
    """Azimuth modes 1 to M of a sea BRDF, sr-1, averaged over wind directions.

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

    def repeated(self, columns: int) -> SeaModes:
        """Return the modes of the sea repeated for C columns, (..., C x V)."""
        if columns == 1:
            return self
        return SeaModes(*(np.tile(each, columns) for each in (self.view, self.sun, self.between)))


def unlit_sea_modes(sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections, modes: int) -> SeaModes:
    """Return the modes of a sea model's BRDF from 1 to ``modes`` - 1; those of the sun are 0."""
    streams = directions.streams.mu
    count = streams.size
    first, second = (each.ravel() for each in np.meshgrid(streams, streams, indexing="ij"))
    between = _expanded(sea, wavenumber_cm1, first, second, modes)
    view = _expanded(sea, wavenumber_cm1, np.full(count, directions.mu[VIEW]), streams, modes)
    return SeaModes(view, np.zeros_like(view), between.reshape(modes - 1, count, count, -1))


def sunlit_modes(unlit: SeaModes, sea: SeaModel, wavenumber_cm1: Array, directions: ColumnDirections) -> SeaModes:
    """Return the modes, completed for the sun of ``directions``."""
    streams = directions.streams.mu
    toward_sun = np.full(streams.size, directions.mu_sun)
    sun = _expanded(sea, wavenumber_cm1, streams, toward_sun, unlit.view.shape[0] + 1)
    return replace(unlit, sun=sun)


def _expanded(sea: SeaModel, wavenumber_cm1: Array, mu_out: Array, mu_in: Array, modes: int) -> Array:
    """Return the modes (M, P, V) of a sea BRDF for pairs of directions (P,)."""
    azimuths = max(_LEAST_AZIMUTHS, modes + _MORE_AZIMUTHS)
    azimuth = (np.arange(azimuths) + 0.5) * np.pi / azimuths
    cosine = np.cos(np.arange(1, modes)[:, None] * azimuth) / azimuths
    many = mu_out.size
    brdf = sea.brdf(wavenumber_cm1, np.repeat(mu_out, azimuths), np.repeat(mu_in, azimuths), np.tile(azimuth, many))
    result: Array = np.einsum("ma,pav->mpv", cosine, brdf.reshape(many, azimuths, -1))
    return result


def turned_glint(columns: SceneColumns, modes: SeaModes) -> tuple[Array, Array]:
    """Return the sunlight to add to the cloud and sea terms, both (S,), in columns with one cloud.

    The cloud term contains light that the cloud scatters on the way down, the sea term light that reaches the sea
    directly. ``modes`` (..., S) are those of each column.
    """
    slab, where = columns.slabs[0], columns.directions
    sun = where.sun
    assert sun is not None
    weight = 2.0 * np.pi * where.streams.mu * where.streams.weight
    turn = 2.0 * np.cos(np.arange(1, modes.view.shape[0] + 1) * where.relative_azimuth)
    from_view, from_sun = slab.beam_transmission[:, 0], slab.beam_transmission[:, 1]
    view_deg = where.zenith_deg[VIEW]
    stream_deg = [where.zenith_deg[index] for index in where.stream_indices]
    ends = list(zip(slab.base_m, slab.top_m, strict=True))
    air = columns.air
    below = air.crossed([[Path((Leg(0.0, base, zenith),)) for base in slab.base_m] for zenith in stream_deg])
    through = air.crossed(
        [
            [Path((Leg(top, SPACE, view_deg), Leg(base, top, z), Leg(0.0, base, z))) for base, top in ends]
            for z in stream_deg
        ]
    )
    from_sea = columns.crossed(lambda _: to_space(0.0, view_deg))
    to_base = columns.crossed(lambda number: to_space(slab.base_m[number], sun.zenith_deg))
    seen = air.transmittance(below + from_sea + to_base)
    down = np.einsum("m,j,mjv,mjv,jv->v", turn, weight, modes.view, from_sun, seen)
    seen = air.transmittance(through + columns.crossed(lambda _: to_space(0.0, sun.zenith_deg)))
    up = np.einsum("m,j,mjv,mjv,jv->v", turn, weight, from_view, modes.sun, seen)
    upward, downward = (each.ravel() for each in np.indices((weight.size, weight.size)))
    seen = air.transmittance(through.take(upward) + below.take(downward) + to_base)
    seen = seen.reshape(weight.size, weight.size, -1)
    left = from_view * weight[:, None] * turn[:, None, None]
    right = from_sun * weight[:, None]
    both = np.einsum("mjv,mjkv,mkv,jkv->v", left, modes.between, right, seen, optimize=True)
    received = columns.received
    return received * (slab.direct[VIEW] * down + both), received * slab.sun_direct * up
