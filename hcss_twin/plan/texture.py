"""Texture of clear sky: how far sea temperature and water vapour of a pixel differ from those of the scene.

The radiance of a pixel is interpolated between tables of the scene and of perturbed states: over a warmer sea, and in
drier and moister air. Beneath thick cloud the states agree, so that the texture vanishes there by itself.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cache import kept_result
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.error_norm import largest_error
from hcss_twin.models.sea.texture import SEA_TEMPERATURE, WATER_VAPOUR, TextureField, cells_of
from hcss_twin.plan.accuracy import requested_accuracy
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.clear_sky import EVEN_SKY, EVEN_VAPOUR, STEP, EvenFields, EvenSky, State, VapourNodes
from hcss_twin.plan.clear_sky_sizes import DEFAULT_K, DEFAULT_VAPOUR, is_faint, typical_sea_K
from hcss_twin.plan.combinations import Excluded, NotComputed, present
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.numerics import for_spectra
from hcss_twin.providers import Sun
from hcss_twin.providers.column_states import spectra_of
from hcss_twin.scenario.scenario import Scenario

OWN_SPECTRA: Sequence[State] = ((1.0, 0.0), (0.0, 1.0))
"""States whose spectra tell which wavenumbers their differences from the scene need."""


class Texture(EvenSky):
    """Standard deviations of a scene's clear-sky texture; at least one is above 0."""

    varies = True

    def key(self, scenario: Mapping[str, Any], assembly: Assembly) -> Mapping[str, Any]:
        """Return the deviations; those of a small image are others."""
        return {"texture": astuple(self)}

    def with_own_spectra(self, assembly: Assembly) -> list[Assembly]:
        """Return the perturbed scenes, unless all differences are proportional to terms of the scene."""
        if self.water_vapour == 0.0 and self.sea_is_proportional(assembly):
            return []
        return [self.perturbed(assembly, state) for state in OWN_SPECTRA]

    def fields(self, scenario: Scenario, assembly: Assembly) -> EvenFields:
        """Return the fields of the scene."""
        return TextureFields(scenario, assembly, self)

    @property
    def finest(self) -> VapourNodes:
        """Nodes between which the certificate interpolates: at least as many as there are tables."""
        return nodes_between(self.vapour.kinks, FINEST)

    @property
    def expansion_states(self) -> tuple[State, ...]:
        """States (S,) between which the certificate interpolates."""
        return expansion_states(self.finest)

    def change_between(
        self, values: Array, warmer: NDArray[np.float32], drier: NDArray[np.float32]
    ) -> tuple[Array, Array]:
        """Return how values (S, ...) at :func:`expansion_states` of the tables change, as that of an even sky."""
        nothing = super().change_between(values, warmer, drier)
        if not values.size:  # without radiance
            return nothing
        if self.water_vapour == 0.0:  # few pixels are asked for their change, all for their vapour
            by_sea = Expansion(values, self.vapour)
            return nothing[0], np.stack([by_sea.warm - by_sea.square, by_sea.square])
        of_pixels = Expansion(values[..., None, None], self.vapour)
        return of_pixels(warmer.astype(np.float64), drier.astype(np.float64)), nothing[1]

    def change(self, perturbation: Array, in_states: Callable[[], Array]) -> Array | float:
        """Return how quantities (N, Q, B) change at perturbations (N, 2), by the polynomial through the states."""
        warmer, drier = perturbation.T[..., None, None]
        return Expansion(in_states(), self.finest)(warmer, drier)


class TextureFields(EvenFields):
    """Both fields of a scene, in steps."""

    def __init__(self, scenario: Scenario, assembly: Assembly, texture: Texture) -> None:
        motion, grid, self._texture = assembly.motion, assembly.grid, texture
        speed, wind = motion.platform_speed_m_s, motion.cloud_velocity_m_s
        self._sea = TextureField(SEA_TEMPERATURE, scenario.seed, grid, platform_speed_m_s=speed)
        self._vapour = TextureField(WATER_VAPOUR, scenario.seed, grid, wind, speed)
        self._in_steps = cached_method(self._new_in_steps, 2)  # the window of the frame before, of both fields

    def at(self, time_s: float, rows: slice, columns: slice) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return how far pixels (y, x) are perturbed, in steps toward warm sea and toward dry air."""
        texture, window = self._texture, (rows.start, rows.stop, columns.start, columns.stop)
        vapour_step = -STEP * texture.vapour_share
        return (
            self._in_steps(self._sea, texture.temperature_K, STEP, 0.0 if self._sea.is_still else time_s, *window),
            self._in_steps(self._vapour, texture.water_vapour, vapour_step, time_s, *window),
        )

    @staticmethod
    def _new_in_steps(
        field: TextureField, deviation: float, step: float, time_s: float, top: int, bottom: int, left: int, right: int
    ) -> NDArray[np.float32]:
        """Return a field in steps, which its readers share."""
        if deviation == 0.0:
            values = np.zeros((bottom - top, right - left), np.float32)
        else:
            values = field.at(time_s, slice(top, bottom), slice(left, right))
            values /= np.float32(step)
        values.flags.writeable = False
        return values


PARABOLA_SHARE = 0.25
"""Share of the accuracy within which the interpolation between amounts of vapour is good enough."""

TRIED = (-1.2, -0.9, -0.6, -0.3, 0.3, 0.6, 0.9, 1.2)
"""Places, up to two standard deviations, at which it is tried."""

TEXTURE_OF_IMAGE = "clear sky of the clouds' image has a texture of its own"

ON_REQUEST = "its tables take two to three times as long, and err by up to .4 % in hazy air by day"

EVEN_VAPOUR_ON_REQUEST = NotComputed(ON_REQUEST, f"atmosphere.water_vapour_texture = {DEFAULT_VAPOUR:g}")

WIDE_M, THERMAL_UM = 100e3, 5.0
"""Least size of images whose vapour has texture by default, and their shortest wavelength. At 10.8 um it changes them
as much as the sea's texture does, or more; at shorter wavelengths its tables err where there is haze by day."""

SMALL = "the image is smaller than its smallest structures"

FAINT = "it would change less than its share of the accuracy asked for"

REACH = 2.4
"""Places beyond which kinks do not matter: four standard deviations."""

END = 1.8
"""Place of the last node beyond the last kink: three standard deviations."""

NEAR = 0.3
"""Least distance of nodes: between nearer ones, small errors of their tables grow."""

FINEST = 4
"""Largest order of the polynomials without kinks."""


def nodes_between(kinks: Sequence[float], order: int) -> VapourNodes:
    """Return the nodes of an order, and of segments between kinks (ascending).

    Without kinks, the nodes are the scene, at 0, and a step or two from it on either side. With kinks, a segment has
    its ends and, above order 1, a node between: the scene, if it is there.
    """
    if not kinks:
        return VapourNodes(((0.0, 1.0, -1.0, 2.0, -2.0)[: order + 1],))
    first, last = min(-END, kinks[0] - 2.0 * NEAR), max(END, kinks[-1] + 2.0 * NEAR)
    segments = []
    for low, high in pairwise((first, *kinks, last)):
        has_scene = low + NEAR < 0.0 < high - NEAR
        between = (0.0,) if has_scene else (0.5 * (low + high),) * (order > 1 and high - low > 2.0 * NEAR)
        segments.append((low, high, *between))
    return VapourNodes(tuple(segments), tuple(kinks))


def change_weights(nodes: VapourNodes, position: Array) -> Array:
    """Return the weights (N, ...) of how values at N places differ from the scene, in the polynomials at a position."""
    weights, places = np.zeros((len(nodes.places), *np.shape(position))), nodes.places
    which = np.searchsorted(np.array(nodes.kinks), position)
    for number, segment in enumerate(nodes.segments):
        for node in segment:
            if node:
                others = [other for other in segment if other != node]
                weight = np.prod([(position - other) / (node - other) for other in others], axis=0)
                weights[places.index(node)] += np.where(which == number, weight, 0.0)
    return weights


BASE_STATES: Sequence[State] = (
    *((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0)),
    *((1.0, 1.0), (1.0, -1.0), (0.0, 1.0), (0.0, -1.0)),
)


def expansion_states(nodes: VapourNodes) -> tuple[State, ...]:
    """Return the states of an :class:`Expansion`."""
    return *BASE_STATES, *((0.0, place) for place in nodes.places)


@dataclass(frozen=True)
class Expansion:
    """Values (S, ...) at :func:`expansion_states`, and the polynomial through them.

    It has the second order of the sea, and the change by the sea is of second order in the vapour.
    """

    values: Array
    nodes: VapourNodes

    @property
    def warm(self) -> Array:
        """Change by a sea warmer by a step."""
        change: Array = self.values[1] - self.values[0]
        return change

    @property
    def square(self) -> Array:
        """Part of ``warm`` that is quadratic in the perturbation."""
        square: Array = 0.5 * (self.values[1] + self.values[2]) - self.values[0]
        return square

    @property
    def mixed(self) -> Array:
        """Change of ``warm`` (2, ...) with the vapour, linear and quadratic."""
        dry, moist = (self.values[3 + index] - self.values[5 + index] - self.warm for index in (0, 1))
        return np.stack((dry - moist, dry + moist)) / 2.0

    def __call__(self, warmer: Array, drier: Array) -> Array:
        """Return the change at a perturbation."""
        away = self.values[len(BASE_STATES) :] - self.values[0]
        weights = change_weights(self.nodes, drier)
        of_vapour = np.sum([weight * change for weight, change in zip(weights, away, strict=True)], axis=0)
        linear, square = self.mixed
        of_sea = warmer * (self.warm - self.square + linear * drier + square * drier**2) + warmer**2 * self.square
        change: Array = of_vapour + of_sea
        return change


def sea_factors(scene: Assembly, warmer: Assembly, wavenumber_cm1: Array, sun: Sun | None) -> Array:
    """Return by which factor each term (K, V) of clear sky changes over a warmer sea; 1 where there is nothing.

    At one wavenumber the emission of the sea has this factor under any cloud, and what it reflects to first order.
    """
    settings = [scene.setting(sun), warmer.setting(sun)]
    before, after = spectra_of(scene.model, settings, wavenumber_cm1, np.zeros((1, len(scene.layers))))[:, 0]
    factors: Array = np.divide(after, before, out=np.ones_like(before), where=before > 0.0)
    return factors


def excluded_beside_texture(assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with texture of the sea or of vapour."""
    return (Excluded("image", assembly.own_suns, "a full disk, whose places have suns of their own,", "a part"),)


def why_one_temperature(scenario: Scenario, assembly: Assembly) -> str:
    """Return why the sea has one temperature; empty if it has texture."""
    given, light, grid = scenario.sea.temperature_texture, scenario.radiance, assembly.grid
    if given == 0.0:
        return "sea.temperature_texture is 0"
    small = "" if cells_of(SEA_TEMPERATURE, grid) else SMALL
    if given is not None:
        return small
    if excluded := next(present(excluded_beside_texture(assembly)), None):
        return f"the scene has {excluded.what.rstrip(',')}"
    if assembly.surfaces:
        return "the scene has a map of the ground, which has temperatures of its own"
    if light.is_between_columns:
        return "light between columns is compared with a sea of one temperature"
    if assembly.clear_sky_varies:
        return TEXTURE_OF_IMAGE
    return small or (FAINT if is_faint(scenario, assembly, typical_sea_K(grid)) else "")


def why_even_vapour(scenario: Scenario, assembly: Assembly) -> NotComputed | None:
    """Return why the vapour of a scene that leaves it to the plan has no texture; None if it has one."""
    if excluded := next(present(excluded_beside_texture(assembly)), None):
        return NotComputed(f"the scene has {excluded.what.rstrip(',')}")
    if assembly.has_bound_air:
        return NotComputed("the atmosphere's provider has one profile")
    if scenario.radiance.is_between_columns:
        return NotComputed("light between columns is compared with air of one profile")
    if assembly.clear_sky_varies:
        return NotComputed(TEXTURE_OF_IMAGE)
    grid, many = assembly.grid, assembly.directions is not None or assembly.lines_of_sight is not None
    wide = grid.pixel_size_m * max(grid.rows, grid.columns) >= WIDE_M
    if wide and not many and min(band.lower_um for band in assembly.bands) >= THERMAL_UM:
        return None
    return EVEN_VAPOUR_ON_REQUEST


def plan_texture(
    scenario: Scenario, assembly: Assembly, catalog: Catalog, suns: Sequence[Sun | None]
) -> tuple[EvenSky, NotComputed | None]:
    """Return the texture of a scene, an even sky if it has none; and why its vapour has none, or None.

    Parameters
    ----------
    suns : sequence of Sun or None
        Of some frames; empty if no radiance is requested.

    Raises
    ------
    ScenarioError
        If it is given and other keys exclude it.
    """
    given, vapour = scenario.sea.temperature_texture, scenario.atmosphere.water_vapour_texture
    for key, value in {"sea.temperature_texture": given, "atmosphere.water_vapour_texture": vapour}.items():
        if value:
            Excluded.require_none(f"{key} = {value:g}", excluded_beside_texture(assembly), f"{key} = 0")
    kelvin = 0.0 if why_one_temperature(scenario, assembly) else DEFAULT_K if given is None else given
    sky = Texture(kelvin) if kelvin else EVEN_SKY
    if vapour == 0.0:
        return sky, EVEN_VAPOUR
    if vapour is None:
        why = why_even_vapour(scenario, assembly)
        if why is not None or not suns:
            return sky, why or EVEN_VAPOUR_ON_REQUEST
        vapour = DEFAULT_VAPOUR
    share = math.sqrt(sum(of_cell for _, of_cell in cells_of(WATER_VAPOUR, assembly.grid)))
    if share == 0.0:
        return sky, NotComputed(SMALL)
    if not suns:
        return Texture(kelvin, vapour, share), None
    parts = {
        "scenario": {**json.loads(scenario.to_json()), "title": "", "seed": 0, "sensor": None},
        "filled_in": [item.as_dict() for item in assembly.filled_in],
        "files": dict(catalog.used),
        "code": assembly.code,
        "for": "texture of vapour",
    }
    choose = partial(_choose_nodes, scenario, assembly, suns, share * vapour)
    nodes = kept_result(parts, catalog, choose, (VapourNodes,))
    return Texture(kelvin, vapour, share, nodes), None


def _choose_nodes(scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None], deviation: float) -> VapourNodes:
    """Return the fewest amounts of vapour between which clear sky is interpolated accurately enough."""
    tolerance = PARABOLA_SHARE * requested_accuracy(scenario, assembly, suns).relative
    few, step = for_spectra(assembly), STEP * deviation
    columns = few_columns(few)
    columns = columns.only(columns.ends[: 1 if columns.clear else None])

    @cache
    def at(drier: float) -> Array:
        """Return the columns (T, C, B) with vapour at a place."""
        scene = few.perturbed(0.0, 1.0 - step * drier)
        return np.stack(columns.totals_in(scene.model, [scene.setting(sun) for sun in suns]))

    def error(nodes: VapourNodes) -> float:
        exact, away = (np.stack([at(place) for place in places]) for places in (TRIED, nodes.places))
        weights = change_weights(nodes, np.array(TRIED))
        return largest_error(at(0.0) + np.tensordot(weights, away - at(0.0), ((0,), (0,))), exact)

    def candidates() -> Iterator[VapourNodes]:
        yield nodes_between((), 1)
        yield nodes_between((), 2)
        of_provider = getattr(few.transmittance, "vapour_kinks", None)
        if of_provider and (kinks := of_provider(max(1.0 - REACH * step, 0.0), 1.0 + REACH * step)):
            places = tuple(sorted((1.0 - kink) / step for kink in kinks))
            yield from (nodes_between(places, order) for order in (1, 2))
        yield nodes_between((), FINEST)

    tried = []
    for nodes in candidates():
        tried.append((error(nodes), len(nodes.places), nodes))
        if tried[-1][0] <= tolerance:
            return nodes
    # a higher order that is hardly better is not worth its tables
    least = min(found for found, _, _ in tried)
    return next(nodes for found, _, nodes in tried if found <= 2.0 * least)
