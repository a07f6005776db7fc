"""Multiple reflections between interfaces, with fixed gas in front of them, as one linear system.

Following every reflection exactly (:mod:`~hcss_twin.models.radiance.physical.tracing`) multiplies the number of paths
at each change of direction. This closure sums the remaining reflections with one matrix. Transmittances of a spectral
interval do not multiply, so that each of its legs lies behind a path that most of its light has in front of it:

* upward, the view's path to the lower end of the gap, where light is reflected;
* upward in the uppermost gap, into which light comes from below only: the view's path to the lower end of the second
  gap, and up from there;
* downward below the second cloud, through which most light is scattered forward: the view's path to the upper end of
  the gap. Below the first one such light is traced, and the rest has crossed the gap before.

Rows of the matrix and the weights of the sources sum to one, so that an isothermal enclosure closes exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.models.radiance.physical.air import Heights, LegView
from hcss_twin.models.radiance.physical.columns import SceneColumns
from hcss_twin.models.radiance.physical.composite_paths import CompositePaths
from hcss_twin.models.radiance.physical.directions import VIEW
from hcss_twin.models.radiance.physical.terms import CLOUD, CLOUD_SUN, SCATTERED_AIR, SEA, SEA_SUN, TERMS
from hcss_twin.physics.paths import Leg, Path
from hcss_twin.physics.thermal_scattering import DIFFUSE_DEG


@dataclass(frozen=True)
class FrozenLegs:
    """Legs of all streams through gaps and clouds, downward and upward, each behind one path.

    ``sun_*``: transmittance (S,) of the sun's path to an interface, behind the view's path to it. ``down`` and
    ``sun_top`` omit the uppermost gap, into which no stream looks down.
    """

    down: list[LegView]
    up: list[LegView]
    inside_down: list[LegView]
    inside_up: list[LegView]
    sun_top: list[Array]
    sun_base: list[Array]
    sun_sea: Array

    def sun_under(self, cloud: int, gap: int) -> Array:
        """Return the transmittance (N, S) for sunlight that a cloud scatters down to the lower end of a gap."""
        result = self.up[gap].transmittance * self.sun_base[cloud]
        for between in range(cloud + 1, gap):
            result = result * self.up[between].transmittance * self.inside_up[between].transmittance
        return result


@dataclass(frozen=True)
class Closure:
    """Radiances along the streams inside columns, by source.

    Attributes
    ----------
    down : tuple of ndarray (K, N, S)
        For each gap except the uppermost, into which no light is scattered downward; looking down from its upper end.
    up : tuple of ndarray (K, N, S)
        For each gap, looking up from its lower end.
    below, above : tuple of ndarray (K, N, S)
        For each cloud, radiance from the air inside it: from below, seen from its top, and from above, seen from its
        base.
    frozen : FrozenLegs
    """

    down: tuple[Array, ...]
    up: tuple[Array, ...]
    below: tuple[Array, ...]
    above: tuple[Array, ...]
    frozen: FrozenLegs


def close(columns: SceneColumns, traced: bool) -> Closure:
    """Solve u = P u + S for the radiances along the streams in all gaps.

    ``traced``: whether the first change of direction is traced; otherwise all legs lie behind the view's path to the
    lower end of their gap.
    """
    frozen = _freeze(columns, traced)
    gaps, count = len(columns.slabs) + 1, columns.directions.count
    size = columns.received.size
    streams = list(columns.directions.stream_indices)
    # Upward in the uppermost gap; then downward and upward in each below.
    rows = 2 * gaps - 1
    # In memory, the elements of a linear system are neighbours; here wavenumbers are the last axis.
    flat = rows * count
    kernel, right = np.zeros((size, flat, flat)), np.zeros((size, flat, len(TERMS)))
    matrix = np.moveaxis(kernel.reshape(size, rows, count, rows, count), 0, -1)
    source = np.moveaxis(right.reshape(size, rows, count, len(TERMS)), 0, -1)
    for gap in range(gaps):
        if gap > 0:
            _looking_down(columns, frozen, gap, streams, matrix, source)
        _looking_up(columns, frozen, gap, streams, matrix, source)
    solved = _solve(kernel, right, count)
    radiance = np.moveaxis(solved.reshape(size, rows, count, len(TERMS)), (0, 3), (3, 1))
    down = tuple(radiance[2 * gap - 1] for gap in range(1, gaps))
    up = tuple(radiance[2 * gap] for gap in range(gaps))
    below = tuple(_behind(leg, down[i]) for i, leg in enumerate(frozen.inside_down))
    above = tuple(_behind(leg, up[i]) for i, leg in enumerate(frozen.inside_up))
    return Closure(down, up, below, above, frozen)


def _solve(kernel: Array, source: Array, above: int) -> Array:
    """Solve u = P u + S, (V, F, F) and (V, F, N).

    The first ``above`` rows look up from the uppermost gap and see only space, so they need no inversion.
    """
    result = np.empty_like(source)
    sky, inner = source[:, :above], kernel[:, above:, above:]
    result[:, :above] = sky
    if inner.shape[1]:
        right = source[:, above:] + kernel[:, above:, :above] @ sky
        result[:, above:] = np.linalg.solve(np.eye(inner.shape[1])[None] - inner, right)
    return result


def _behind(leg: LegView, beyond: Array) -> Array:
    """Return the radiance (K, N, S) seen through a leg."""
    result: Array = leg.transmittance * beyond
    result[SCATTERED_AIR] += leg.emission
    return result


def _looking_down(
    columns: SceneColumns, frozen: FrozenLegs, gap: int, streams: list[int], matrix: Array, source: Array
) -> None:
    leg = frozen.down[gap - 1]
    row = 2 * gap - 1
    source[row, :, SCATTERED_AIR] += leg.emission
    if gap == len(columns.slabs):
        glint, _ = columns.sun_on_sea()
        source[row, :, SEA] += leg.transmittance * columns.sea.emissivity[streams] * columns.sea_source
        source[row, :, SEA_SUN] += leg.transmittance * glint[streams] * frozen.sun_sea
        matrix[row, :, row + 1] += leg.transmittance[:, None] * columns.sea.reflection[streams]
        return
    sunlight, _ = columns.sun_on_slab(gap, from_above=True)
    source[row, :, CLOUD] += leg.transmittance * columns.slab_emission(gap, from_above=True)[streams]
    source[row, :, CLOUD_SUN] += leg.transmittance * sunlight[streams] * frozen.sun_top[gap - 1]
    matrix[row, :, row + 1] += leg.transmittance[:, None] * columns.slabs[gap].reflection[streams]
    _pass_through(columns, gap, streams, leg, frozen.inside_down[gap], matrix[row], row + 2, source[row])


def _looking_up(
    columns: SceneColumns, frozen: FrozenLegs, gap: int, streams: list[int], matrix: Array, source: Array
) -> None:
    leg = frozen.up[gap]
    row = 2 * gap
    source[row, :, SCATTERED_AIR] += leg.emission
    if gap == 0:
        source[row, :, SCATTERED_AIR] += leg.transmittance * columns.space
        return
    index = gap - 1
    sunlight, _ = columns.sun_on_slab(index, from_above=False)
    source[row, :, CLOUD] += leg.transmittance * columns.slab_emission(index, from_above=False)[streams]
    source[row, :, CLOUD_SUN] += leg.transmittance * sunlight[streams] * frozen.sun_base[index]
    matrix[row, :, row - 1] += leg.transmittance[:, None] * columns.slabs[index].reflection[streams]
    _pass_through(columns, index, streams, leg, frozen.inside_up[index], matrix[row], row - 2, source[row])


def _pass_through(
    columns: SceneColumns,
    index: int,
    streams: list[int],
    leg: LegView,
    inside: LegView,
    matrix: Array,
    beyond: int,
    source: Array,
) -> None:
    """Add the light that a cloud transmits, directly and diffusely, from the gap ``beyond`` it."""
    slab = columns.slabs[index]
    kernel = slab.transmission[streams].copy()
    diagonal = np.arange(len(streams))
    kernel[diagonal, diagonal] += slab.direct[streams]
    matrix[:, beyond] += leg.transmittance[:, None] * kernel * inside.transmittance[None]
    source[:, SCATTERED_AIR] += leg.transmittance * np.einsum("kjv,jv->kv", kernel, inside.emission)


def _freeze(columns: SceneColumns, traced: bool) -> FrozenLegs:
    air, where = columns.air, columns.directions
    view = where.zenith_deg[VIEW]
    zeniths = [where.zenith_deg[index] for index in where.stream_indices]
    gaps = len(columns.slabs) + 1
    front: list[CompositePaths] = []
    to_gap: list[CompositePaths] = []
    paths = [Path()] * columns.count
    for gap in range(gaps):
        to_gap.append(air.crossed([paths]))
        ends = zip(*columns.gap_m(gap), strict=True)
        paths = [path + Path((Leg(lower, upper, view),)) for path, (lower, upper) in zip(paths, ends, strict=True)]
        front.append(air.crossed([paths]))
        if gap < len(columns.slabs):
            paths = [path + Path((columns.inside(gap, number, view),)) for number, path in enumerate(paths)]
    seen = [air.transmittance(crossed) for crossed in front]
    before_down, before_up = list(front), list(front)
    if traced and gaps > 1:
        before_down[2:] = to_gap[2:]
        low, high = columns.gap_m(1)
        back = columns.crossed(
            lambda number: Path((Leg(low[number], high[number], DIFFUSE_DEG), columns.inside(0, number, DIFFUSE_DEG)))
        )
        before_up[0] = front[1] + back

    def legs(before: CompositePaths, lower: Heights, upper: Heights, downward: bool) -> LegView:
        rows = np.zeros(len(zeniths), dtype=np.intp)
        through = air.transmittance(before)[rows]
        view = air.leg(before.take(rows), through, zeniths, lower, upper, downward, columns.scattered_sublayers)
        return view.conditional(through, air.near_source(lower, upper, downward))

    def sun(gap: int, to_sun: CompositePaths) -> Array:
        if where.sun is None:
            return np.zeros_like(columns.received)
        crossed = front[gap] + to_sun
        through = air.transmittance(crossed)
        whole = LegView(np.zeros_like(through), through, crossed)
        result: Array = whole.conditional(seen[gap], np.zeros_like(through)).transmittance[0]
        return result

    clouds = range(len(columns.slabs))
    return FrozenLegs(
        down=[legs(before_down[gap], *columns.gap_m(gap), downward=True) for gap in range(1, gaps)],
        up=[legs(before_up[gap], *columns.gap_m(gap), downward=False) for gap in range(gaps)],
        inside_down=[legs(front[i], columns.slabs[i].base_m, columns.slabs[i].top_m, downward=True) for i in clouds],
        inside_up=[legs(front[i + 1], columns.slabs[i].base_m, columns.slabs[i].top_m, downward=False) for i in clouds],
        sun_top=[sun(i, columns.sun_on_slab(i, from_above=True)[1]) for i in clouds[1:]],
        sun_base=[sun(i + 1, columns.sun_on_slab(i, from_above=False)[1]) for i in clouds],
        sun_sea=sun(gaps - 1, columns.sun_on_sea()[1]),
    )
