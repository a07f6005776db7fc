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

Operators of clouds that scatter each other's light have fewer moments than those of single clouds
(:func:`hcss_twin.physics.multiple_scattering.beams.coupled_moments`): light that crosses a cloud directly is then more,
and what the columns count of both, direct light and mode 0, is replaced.

Light that is scattered on its way down and on its way up changes its direction twice more than direct light. In the
columns, gas is exact for one change only, and absorbs too much behind others: its transmittances are then multiplied.
More streams count less light as direct, so that their radiance would be further from the truth (by 1.4e-3 with 20
streams, 0.3e-3 with 6: thin stratus near the glint at 3 um). This light crosses the gas of its whole path here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights
from hcss_twin.models.radiance.physical.closure import FrozenLegs
from hcss_twin.models.radiance.physical.cloud_slab import CloudSlab
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.composite_paths import CompositePaths
from hcss_twin.models.radiance.physical.directions import VIEW
from hcss_twin.models.radiance.physical.sea_surface import ReflectionModes
from hcss_twin.models.radiance.physical.sunlight_mirrored import Mirror, mirrored
from hcss_twin.physics.multiple_scattering.beams import coupled_moments
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space


class _PairedModes(ReflectionModes):
    """As :class:`ReflectionModes`, with ``between`` (M, P, V) between the P pairs of streams of ``np.triu_indices``."""

    def rows(self) -> Iterator[Array]:
        yield from _rows(self.between)


def sunlight_between(
    columns: SceneColumns, frozen: FrozenLegs | None, sea: ReflectionModes, mirror: Mirror | None = None
) -> tuple[Array, Array]:
    """Return the sunlight to add to the cloud and sea terms, both (S,), in columns with clouds.

    The sea term contains light that reaches the sea directly, the cloud term light that clouds scatter on the way down
    or reflect.

    Parameters
    ----------
    columns : SceneColumns
    frozen : FrozenLegs or None
        Gas by which the columns count light that is scattered both ways; None: that of its whole path.
    sea, mirror : ReflectionModes, Mirror
        Modes (..., V) of the sea, and the same along more streams.
    """
    cloud, glint = np.zeros_like(columns.received), np.zeros_like(columns.received)
    light: list[_Transmitted] = []
    coupled: list[_Transmitted] = []
    direct = np.ones((2, columns.received.size))
    coupled_direct = direct
    for index, slab in enumerate(columns.slabs):
        light = _below(columns, slab, light, direct, _single(columns, slab))
        direct = direct * np.stack((slab.direct[VIEW], slab.sun_direct))
        if index + 1 < len(columns.slabs):
            coupled = _below(columns, slab, coupled, coupled_direct, _completed(columns, slab, 1))
            coupled_direct = coupled_direct * _direct(columns, slab)[-2:]
            cloud += _mutual(columns, frozen, index + 1, (light, direct), (coupled, coupled_direct))
        else:
            turn = np.concatenate(([-1.0], _turn(columns, light[0].beams.shape[0])))
            down, up = _reflected(
                columns,
                frozen,
                [replace(each, beams=np.concatenate((each.beams[:1], each.beams))) for each in light],
                direct,
                _with_mean(columns, sea.repeated(columns.count)),
                columns.sea_level_m,
                turn,
            )
            seen = columns.air.transmittance(_path(columns, columns.sea_level_m))[0]
            if mirror is not None:
                beams = np.sum([transmitted.beams for transmitted in light], axis=0)
                more = mirrored(columns.slabs, columns.directions, mirror, sea, beams, direct) * seen
                down, up = down + more[0], up + more[1]
            cloud += down
            glint += up
    return columns.received * cloud, columns.received * glint


def _with_mean(columns: SceneColumns, sea: ReflectionModes) -> ReflectionModes:
    """Return the modes of the sea behind mode 0, twice; light scattered one way has no part of it."""
    dark = np.zeros((2, *sea.view.shape[1:]))
    mean = columns.sea.reflection[VIEW + 1 :] / _weight(columns)[:, None]
    return ReflectionModes(
        np.concatenate((dark, sea.view)),
        np.concatenate((dark, sea.sun)),
        np.concatenate((mean[None], mean[None], sea.between)),
    )


def _path(columns: SceneColumns, level: Heights) -> CompositePaths:
    """Return the path from the sun to a level and on to the sensor, in each column."""
    sun = columns.directions.sun
    assert sun is not None
    view_deg = columns.directions.zenith_deg[VIEW]
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


def _below(
    columns: SceneColumns, slab: CloudSlab, above: list[_Transmitted], direct: Array, diffuse: Array
) -> list[_Transmitted]:
    """Return the light below a cloud, given that above it.

    Parameters
    ----------
    direct : ndarray (2, S)
        Transmission of view and sun above the cloud.
    diffuse : ndarray (1 + M, 2, N, S)
        Diffuse transmission of both by the cloud.
    """
    beams = diffuse * direct[:, None]
    if not above:
        return [_Transmitted(slab.base_m, slab.top_m, beams)]
    onto = np.sum([transmitted.beams for transmitted in above], axis=0) * _weight(columns)[:, None]
    pairs = _pairs(columns, slab, 1)[: beams.shape[0]]
    for stream, row in enumerate(_rows(pairs)):
        beams[: len(pairs), :, stream] += np.einsum("mjv,mbjv->mbv", row, onto[: len(pairs)])
    along = _direct(columns, slab)[:-2]
    passed = [replace(transmitted, beams=transmitted.beams * along) for transmitted in above]
    return [*passed, _Transmitted(slab.base_m, slab.top_m, beams)]


def _single(columns: SceneColumns, slab: CloudSlab) -> Array:
    """Return the modes (1 + M, 2, N, S) of the diffuse transmission of view and sun by a cloud alone."""
    return np.concatenate((_mean(columns, slab, 1)[None], slab.beam_transmission))


def _mean(columns: SceneColumns, slab: CloudSlab, transmitted: int) -> Array:
    """Return mode 0 (2, N, S) of reflection, or transmission, of view and sun by a cloud alone."""
    kernel, sun = (slab.transmission, slab.sun_transmission) if transmitted else (slab.reflection, slab.sun_reflection)
    return np.stack((kernel[VIEW] / _weight(columns)[:, None], sun[1:]))


def _completed(columns: SceneColumns, slab: CloudSlab, transmitted: int) -> Array:
    """Return the modes (M, 2, N, S) of reflection, or transmission, of a cloud beside others, from 0 on."""
    result: Array = slab.coupled_beams[:, transmitted].copy()
    result[:1] += _mean(columns, slab, transmitted)
    return result


def _mean_pairs(columns: SceneColumns, slab: CloudSlab, transmitted: int) -> Array:
    """Return mode 0 (P, S) between streams by a cloud alone."""
    first, second = np.triu_indices(columns.directions.count)
    kernel = slab.transmission if transmitted else slab.reflection
    result: Array = kernel[1 + first, second] / _weight(columns)[second, None]
    return result


def _pairs(columns: SceneColumns, slab: CloudSlab, transmitted: int) -> Array:
    """Return the modes (M, P, S) between streams of a cloud beside others, from 0 on."""
    result = slab.between_streams[:, transmitted].astype(np.float64)
    result[:1] += _mean_pairs(columns, slab, transmitted)
    return result


def _direct(columns: SceneColumns, slab: CloudSlab) -> Array:
    """Return the direct transmission (N + 2, S) along streams, view and sun of a cloud beside others."""
    where = columns.directions
    depth = slab.optical_thickness * (1.0 - slab.albedo * slab.moments[coupled_moments(where.count)])
    result: Array = np.exp(-depth / np.array([*where.streams.mu, where.mu[VIEW], where.mu_sun])[:, None])
    return result


def _mutual(
    columns: SceneColumns,
    frozen: FrozenLegs | None,
    index: int,
    single: tuple[list[_Transmitted], Array],
    coupled: tuple[list[_Transmitted], Array],
) -> Array:
    """Return the sunlight (S,) per received one that a cloud below others reflects, less what the columns count of it.

    Parameters
    ----------
    single, coupled : (list of _Transmitted, ndarray (2, S))
        Diffuse and direct light above the cloud, by operators of single clouds and of clouds beside others.
    """
    slab = columns.slabs[index]
    before, after = _mean(columns, slab, 0)[None], _completed(columns, slab, 0)
    sign = (-1.0) ** np.arange(len(after))[:, None, None]
    # What the columns count is one more mode, to be subtracted. A beam crosses the clouds above directly.
    view, sun = (
        np.concatenate((before[:, beam] * single[1][beam], after[:, beam] * sign * coupled[1][beam]))
        for beam in range(2)
    )
    pairs = np.concatenate((_mean_pairs(columns, slab, 0)[None], _pairs(columns, slab, 0) * sign))
    light = [
        replace(few, beams=np.concatenate((many.beams[:1], few.beams[: len(after)])))
        for many, few in zip(single[0], coupled[0], strict=True)
    ]
    turn = np.concatenate(([-1.0], _turn(columns, len(after))))
    one = np.ones_like(single[1])
    down, up = _reflected(columns, frozen, light, one, _PairedModes(view, sun, pairs), slab.top_m, turn)
    more = (coupled[1][0] * coupled[1][1] - single[1][0] * single[1][1]) * slab.sun_reflection[VIEW]
    lit = np.any(slab.coupled_beams, axis=(0, 1, 2, 3))
    result: Array = lit * (down + up + more * columns.air.transmittance(_path(columns, slab.top_m))[0])
    return result


def _turn(columns: SceneColumns, modes: int) -> Array:
    turn: Array = 2.0 * np.cos(np.arange(modes) * columns.directions.relative_azimuth)
    turn[0] = 1.0
    return turn


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
    columns: SceneColumns,
    frozen: FrozenLegs | None,
    light: list[_Transmitted],
    direct: Array,
    modes: ReflectionModes,
    lower_m: Heights,
    turn: Array,
) -> tuple[Array, Array]:
    """Return the light (S,) per received sunlight that a surface at ``lower_m`` reflects once.

    Parameters
    ----------
    light : list of _Transmitted
        Behind one cloud each, from the highest on; in the same modes as ``modes``. The first is what the columns count.
    turn : ndarray (M,)
        Factor of each mode toward the view.

    Returns
    -------
    down, up : ndarray (S,)
        Scattered by clouds on the way down, or only on the way up.
    """
    where, air, weight = columns.directions, columns.air, _weight(columns)
    sun = where.sun
    assert sun is not None
    view_deg = where.zenith_deg[VIEW]
    stream_deg = [where.zenith_deg[index] for index in where.stream_indices]
    numbers = range(columns.count)
    from_surface = columns.crossed(lambda number: to_space(lower_m[number], view_deg))
    to_surface = columns.crossed(lambda number: to_space(lower_m[number], sun.zenith_deg))
    down = up = np.zeros_like(columns.received)
    counted = np.zeros((2, weight.size, columns.received.size))
    seen_down, seen_up = [], []
    for cloud, transmitted in enumerate(light):
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
        down = down + np.einsum("m,j,mjv,mjv,jv->v", turn, weight, modes.view, transmitted.beams[:, 1], seen_down[-1])
        up = up + np.einsum("m,j,mjv,mjv,jv->v", turn, weight, transmitted.beams[:, 0], modes.sun, seen_up[-1])
        if frozen is not None:
            gas = air.transmittance(through), frozen.sun_under(cloud, len(light))
            counted += transmitted.beams[0] * weight[:, None] * np.stack(gas)
    # Light scattered both ways sees the air as if the lowest cloud scattered it, times the ratio for one way.
    from_view, from_sun = (
        sum(
            transmitted.beams[:, beam] * _ratio(transmittance, seen[-1])
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
    exact = slice(0 if frozen is None else 1, None)
    left, right = left[exact], right[exact]
    for stream, row in enumerate(modes.rows()):
        both += np.sum(left[:, stream] * np.einsum("mkv,mkv,kv->mv", row[exact], right, seen[stream]), axis=0)
        both += turn[0] * counted[0, stream] * np.einsum("kv,kv->v", row[0], counted[1])
    return direct[0] * down + both, direct[1] * up


def _ratio(transmittance: Array, reference: Array) -> Array:
    """Return the ratio of transmittances; 0 behind opaque air."""
    return np.divide(transmittance, reference, out=np.zeros_like(reference), where=reference > 1e-100)
