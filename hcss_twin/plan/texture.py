"""Texture of clear sky: how far sea temperature and water vapour of a pixel differ from those of the scene.

The radiance of a pixel is interpolated between tables of the scene and of perturbed states: over a warmer sea, and in
drier and moister air. Beneath thick cloud the states agree, so that the texture vanishes there by itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.models.sea.texture import SEA_TEMPERATURE, WATER_VAPOUR, TextureField, cells_of
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.clear_sky import EVEN_SKY, STEP, EvenFields, EvenSky, State
from hcss_twin.plan.combinations import Excluded, present
from hcss_twin.plan.windows import length
from hcss_twin.providers import Grid, Sun
from hcss_twin.providers.column_states import spectra_of
from hcss_twin.scenario.scenario import Scenario

DEFAULT_K = 0.3
"""Standard deviation of the sea's temperature over some hundred km where a scenario gives none. That of clear pixels in
10.8 um SEVIRI images (3 km) is .15 to .49 K over some 200 km, by place and night, of which water vapour is a part."""

LEAST_K = 0.02
"""Standard deviation within the image below which there is texture on request only: the noise of good sensors."""

VAPOUR_PLACES = (1.0, -1.0, 2.0, -2.0)
"""Perturbations of the vapour with tables, in steps toward dry air; the first two where a parabola is enough."""

OWN_SPECTRA: Sequence[State] = ((1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
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

    def change(self, perturbation: Array, in_states: Callable[[], Array]) -> Array | float:
        """Return how quantities (N, Q, B) change at perturbations (N, 2), by the polynomial through the states."""
        warmer, drier = perturbation.T[..., None, None]
        return Expansion(in_states())(warmer, drier)


class TextureFields(EvenFields):
    """Both fields of a scene, in steps."""

    def __init__(self, scenario: Scenario, assembly: Assembly, texture: Texture) -> None:
        motion, grid, self._texture = assembly.motion, assembly.grid, texture
        speed, wind = motion.platform_speed_m_s, motion.cloud_velocity_m_s
        self._sea = TextureField(SEA_TEMPERATURE, scenario.seed, grid, platform_speed_m_s=speed)
        self._vapour = TextureField(WATER_VAPOUR, scenario.seed, grid, wind, speed)

    def at(self, time_s: float, rows: slice, columns: slice) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return how far pixels (y, x) are perturbed, in steps toward warm sea and toward dry air."""

        def in_steps(field: TextureField, deviation: float, step: float) -> NDArray[np.float32]:
            if deviation == 0.0:
                return np.zeros((length(rows), length(columns)), np.float32)
            values = field.at(time_s, rows, columns)
            values /= np.float32(step)
            return values

        warmer = in_steps(self._sea, self._texture.temperature_K, STEP)
        return warmer, in_steps(self._vapour, self._texture.water_vapour, -STEP)


def change_weights(places: Sequence[float], position: Array) -> Array:
    """Return the weights (N, ...) of how values at N places differ from the scene, in the polynomial at a position.

    The polynomial is that of degree N through these values and that of the scene, at 0.
    """
    weights = []
    for node in places:
        others = [0.0, *(other for other in places if other != node)]
        weights.append(np.prod([(position - other) / (node - other) for other in others], axis=0))
    return np.stack(weights)


EXPANSION_STATES: Sequence[State] = (
    *((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -1.0)),
    *((0.0, vapour_place) for vapour_place in VAPOUR_PLACES),
)


@dataclass(frozen=True)
class Expansion:
    """Values (9, ...) at :data:`EXPANSION_STATES`, and the polynomial through them.

    It has the second order of the sea and the fourth of the vapour, and the change by the sea is of second order in the
    vapour.
    """

    values: Array

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

    def __call__(self, warmer: Array, drier: Array, places: int = len(VAPOUR_PLACES)) -> Array:
        """Return the change at a perturbation, from some of the states of vapour only."""
        weights = change_weights(VAPOUR_PLACES[:places], drier)
        away = self.values[5 : 5 + places] - self.values[0]
        of_vapour = np.sum([weight * difference for weight, difference in zip(weights, away, strict=True)], axis=0)
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


def typical_texture_K(grid: Grid) -> float:
    """Return the default standard deviation of the sea's temperature within an image."""
    return DEFAULT_K * math.sqrt(sum(share for _, share in cells_of(SEA_TEMPERATURE, grid)))


def excluded_beside_texture(assembly: Assembly) -> tuple[Excluded, ...]:
    """Return what cannot be computed with texture of the sea or of vapour."""
    return (Excluded("image", assembly.own_suns, "a full disk, whose places have suns of their own,", "a part"),)


def why_one_temperature(scenario: Scenario, assembly: Assembly) -> str:
    """Return why the sea has one temperature; empty if it has texture."""
    given, light, typical_K = scenario.sea.temperature_texture, scenario.radiance, typical_texture_K(assembly.grid)
    small = f"structures within the image vary by {typical_K:.1g} K (standard deviation)"
    if given is not None:
        return "sea.temperature_texture is 0" if given == 0.0 else "" if typical_K else small
    if excluded := next(present(excluded_beside_texture(assembly)), None):
        return f"the scene has {excluded.what.rstrip(',')}"
    if assembly.surfaces:
        return "the scene has a map of the ground, which has temperatures of its own"
    if light.is_between_columns:
        return "light between columns is compared with a sea of one temperature"
    if any(assembly.from_images):
        return "clear sky of the clouds' image has a texture of its own"
    return small if typical_K < LEAST_K else ""


def plan_texture(scenario: Scenario, assembly: Assembly) -> EvenSky:
    """Return the texture of a scene; an even sky if it has none.

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
    vapour = vapour if cells_of(WATER_VAPOUR, assembly.grid) else 0.0
    return Texture(kelvin, vapour) if kelvin or vapour else EVEN_SKY
