"""Azimuth modes of sunlight between clouds, and between clouds and the sea: the glint seen through thin clouds.

Diffuse light along the streams is an azimuth mean. Sunlight scattered forward by a thin cloud is not azimuthally
uniform: it still comes from near the sun, and the sea reflects it into the glint. With the modes T_m of the
transmission of the clouds above a surface, and R_m of that surface, the sea or a lower cloud, the azimuth mean omits,
for one reflection,

    sum over m of 2 cos(m phi) [t_view R_m(view, k) T_m(k, sun) + T_m(view, j) R_m(j, sun) t_sun
                                + T_m(view, j) R_m(j, k) T_m(k, sun)]

with streams j and k weighted by 2 pi mu w, direct transmissions t, and the air of each path in front of it. Several
clouds transmit what the upper ones and then the lowest scatter:

    T_m(k, sun) = t_k T_m_upper(k, sun) + t_sun T_m_lowest(k, sun) + sum over j of T_m_lowest(k, j) T_m_upper(j, sun).

Between clouds, light of the last sum is taken to travel along the beam, from which clouds scatter it little.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.composite_paths import CompositePaths
from hcss_twin.models.radiance.physical.directions import VIEW
from hcss_twin.models.radiance.physical.sea_surface import ReflectionModes
from hcss_twin.models.radiance.physical.sunlight_mirrored import Mirror, mirrored
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space


class _PairedModes(ReflectionModes):
    """As :class:`ReflectionModes`, with ``between`` (M, P, V) between the P pairs of streams of ``np.triu_indices``."""

    def rows(self) -> Iterator[Array]:
        yield from _rows(self.between)


def sunlight_between(columns: SceneColumns, sea: ReflectionModes, mirror: Mirror | None = None) -> tuple[Array, Array]:
    """Return the sunlight to add to the cloud and sea terms, both (S,), in columns with clouds.

    The sea term contains light that reaches the sea directly, the cloud term light that clouds scatter on the way down
    or reflect. ``sea`` (..., V) are the modes of the sea, and ``mirror`` those along more streams.
    """
    cloud, glint = np.zeros_like(columns.received), np.zeros_like(columns.received)
    light: list[_Transmitted] = []
    direct = np.ones((2, columns.received.size))
    for index, slab in enumerate(columns.slabs):
        light = _below(columns, slab, light, direct)
        direct = direct * np.stack((slab.direct[VIEW], slab.sun_direct))
        if index + 1 < len(columns.slabs):
            lower = columns.slabs[index + 1]
            down, up = _reflected(columns, light, direct, _modes_of(lower), lower.top_m)
            cloud += down + up
        else:
            down, up = _reflected(columns, light, direct, sea.repeated(columns.count), columns.sea_level_m)
            seen = columns.air.transmittance(_glint_path(columns))[0]
            if mirror is not None:
                beams = np.sum([transmitted.beams for transmitted in light], axis=0)
                more = mirrored(columns.slabs, columns.directions, mirror, sea, beams, direct) * seen
                down, up = down + more[0], up + more[1]
            cloud += down
            glint += up
    return columns.received * cloud, columns.received * glint


def _glint_path(columns: SceneColumns) -> CompositePaths:
    """Return the path from the sun to the sea and on to the sensor, in each column."""
    sun = columns.directions.sun
    assert sun is not None
    view_deg, level = columns.directions.zenith_deg[VIEW], columns.sea_level_m
    to_sensor = columns.crossed(lambda number: to_space(level[number], view_deg))
    return to_sensor + columns.crossed(lambda number: to_space(level[number], sun.zenith_deg))


@dataclass(frozen=True)
class _Transmitted:
    """Sunlight below clouds that some cloud scattered last.

    Attributes
    ----------
    base_m, top_m : tuple of float (C,)
        Of that cloud; the light crosses later clouds directly.
    beams : ndarray (1 + M, 2, N, S)
        sr-1, modes from 0 on, of view and sun, toward the streams.
    """

    base_m: Heights
    top_m: Heights
    beams: Array


def _below(columns: SceneColumns, slab: CloudSlab, above: list[_Transmitted], direct: Array) -> list[_Transmitted]:
    """Return the light below a cloud, given that above it; ``direct`` (2, S) transmission of view and sun above it."""
    streams, weight = slab.direct[1:], _weight(columns)[:, None]
    mean = np.stack((slab.transmission[VIEW] / weight, slab.sun_transmission[1:]))
    beams = np.concatenate((mean[None], slab.beam_transmission)) * direct[:, None]
    if above:
        onto = np.sum([transmitted.beams for transmitted in above], axis=0) * weight
        rows = _rows(slab.between_streams[:, 1])
        beams = beams + np.stack([np.einsum("mjv,mbjv->mbv", row, onto) for row in rows], axis=2)
    passed = [replace(transmitted, beams=transmitted.beams * streams) for transmitted in above]
    return [*passed, _Transmitted(slab.base_m, slab.top_m, beams)]


def _modes_of(slab: CloudSlab) -> ReflectionModes:
    """Return the modes of the reflection of a cloud, of bearings: light travels away from the bearing of the sun."""
    sign = (-1.0) ** np.arange(slab.between_streams.shape[0])[:, None, None]
    view, sun = (slab.beam_reflection[:, number] * sign for number in range(2))
    return _PairedModes(view, sun, slab.between_streams[:, 0] * sign)


def _rows(pairs: Array) -> Iterator[Array]:
    """Yield, stream by stream, the symmetric modes (M, N, S) of P pairs of streams, (M, P, S)."""
    count = math.isqrt(2 * pairs.shape[1])
    first, second = np.triu_indices(count)
    for stream in range(count):
        yield pairs[:, (first == stream) | (second == stream)]


def _weight(columns: SceneColumns) -> Array:
    streams = columns.directions.streams
    return 2.0 * np.pi * streams.mu * streams.weight


def _reflected(
    columns: SceneColumns, light: list[_Transmitted], direct: Array, modes: ReflectionModes, lower_m: Heights
) -> tuple[Array, Array]:
    """Return the light (S,) per received sunlight that a surface at ``lower_m`` reflects once.

    Returns
    -------
    down, up : ndarray (S,)
        Scattered by clouds on the way down, or only on the way up.
    """
    where, air, weight = columns.directions, columns.air, _weight(columns)
    sun = where.sun
    assert sun is not None
    turn = 2.0 * np.cos(np.arange(light[0].beams.shape[0]) * where.relative_azimuth)
    turn[0] = 1.0
    first = turn.size - modes.view.shape[0]
    turn = turn[first:]
    view_deg = where.zenith_deg[VIEW]
    stream_deg = [where.zenith_deg[index] for index in where.stream_indices]
    numbers = range(columns.count)
    from_surface = columns.crossed(lambda number: to_space(lower_m[number], view_deg))
    to_surface = columns.crossed(lambda number: to_space(lower_m[number], sun.zenith_deg))
    down = up = np.zeros_like(columns.received)
    seen_down, seen_up = [], []
    for transmitted in light:
        base, top = transmitted.base_m, transmitted.top_m
        below = air.crossed([[Path((Leg(lower_m[n], base[n], z),)) for n in numbers] for z in stream_deg])
        to_base = columns.crossed(lambda number, base=base: to_space(base[number], sun.zenith_deg))  # type: ignore[misc]
        through = air.crossed(
            [
                [
                    Path((Leg(top[n], SPACE, view_deg), Leg(base[n], top[n], z), Leg(lower_m[n], base[n], z)))
                    for n in numbers
                ]
                for z in stream_deg
            ]
        )
        seen_down.append(air.transmittance(below + from_surface + to_base))
        seen_up.append(air.transmittance(through + to_surface))
        down = down + np.einsum(
            "m,j,mjv,mjv,jv->v", turn, weight, modes.view, transmitted.beams[first:, 1], seen_down[-1]
        )
        up = up + np.einsum("m,j,mjv,mjv,jv->v", turn, weight, transmitted.beams[first:, 0], modes.sun, seen_up[-1])
    # Light scattered both ways sees the air as if the lowest cloud scattered it, times the ratio for one way.
    from_view, from_sun = (
        sum(
            transmitted.beams[first:, beam] * _ratio(transmittance, seen[-1])
            for transmitted, transmittance in zip(light, seen, strict=True)
        )
        for beam, seen in enumerate((seen_up, seen_down))
    )
    upward, downward = (index.ravel() for index in np.indices((weight.size, weight.size)))
    seen = air.transmittance(through.take(upward) + below.take(downward) + to_base)
    left = from_view * weight[:, None] * turn[:, None, None]
    right = from_sun * weight[:, None]
    seen = seen.reshape(weight.size, weight.size, -1)
    both = np.zeros_like(columns.received)
    for stream, row in enumerate(modes.rows()):
        both += np.sum(left[:, stream] * np.einsum("mkv,mkv,kv->mv", row, right, seen[stream]), axis=0)
    return direct[0] * down + both, direct[1] * up


def _ratio(transmittance: Array, reference: Array) -> Array:
    """Return the ratio of transmittances; 0 behind opaque air."""
    return np.divide(transmittance, reference, out=np.zeros_like(reference), where=reference > 1e-100)
