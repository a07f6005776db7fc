"""Laws of transmittance providers that need no reference: paths of no length, divided legs, slant and high paths."""

from __future__ import annotations

from typing import Any

import numpy as np

from hcss_twin.core.errors import HcssError
from hcss_twin.laws.law import Inapplicable, Law, at_least, at_most, near, range_ends, require
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Array, AtmosphereInputs
from hcss_twin.providers.common import FRACTION_TOLERANCE

SLANT_TOLERANCE = 0.03
"""Allowed difference between the transmittance at 60 degrees and that of the vertical path crossed twice.

The air mass at 60 degrees is 1.99 to 2 on the round Earth; tabulated transmittances are interpolated.
"""

DIVISION_TOLERANCE = 2e-3
"""Allowed difference between a leg and its two parts; band models take means of pressure over parts of layers."""

NO_PATH_RADIANCE = "the engine derives path radiance from transmittance"


def path_without_legs_transmits_everything(provider: Any, wavenumber_cm1: Array) -> None:
    """T = 1 for an empty path."""
    near("T of an empty path", provider.transmittance(wavenumber_cm1, [Path()]), 1.0)


def leg_without_length_transmits_everything(provider: Any, wavenumber_cm1: Array) -> None:
    """T = 1 for a leg that ends where it begins, for providers of any legs."""
    _skip_without_legs(provider)
    paths = [Path((Leg(500.0, 500.0, 30.0),)), Path((Leg(2000.0, 2000.0, 0.0),) * 2)]
    near("T of a leg without length", provider.transmittance(wavenumber_cm1, paths), 1.0, atol=1e-12)


def dividing_a_leg_changes_nothing(provider: Any, wavenumber_cm1: Array) -> None:
    """T of a leg is that of its two parts as one path; the product of their transmittances is not."""
    _skip_without_legs(provider)
    for zenith in (0.0, 50.0):
        whole = to_space(0.0, zenith)
        parts = Path((Leg(0.0, 2000.0, zenith), Leg(2000.0, SPACE, zenith)))
        one, other = provider.transmittance(wavenumber_cm1, [whole, parts])
        near(f"T of a leg in two parts, zenith {zenith:g} deg,", other, one, atol=DIVISION_TOLERANCE)


def slant_path_at_60_degrees_is_the_vertical_path_twice(provider: Any, wavenumber_cm1: Array) -> None:
    """The cosine is one half, so that the slant path holds twice the air."""
    low, high = provider.declares.valid.get("view_zenith", (0.0, 90.0))
    if low > 0.0 or high < 60.0:
        raise Inapplicable("the provider's range of zenith angles excludes 0 or 60 degrees")
    vertical = to_space(0.0, 0.0)
    slant, twice = provider.transmittance(wavenumber_cm1, [to_space(0.0, 60.0), vertical + vertical])
    near("T at zenith 60 deg", slant, twice, atol=SLANT_TOLERANCE)


def there_is_less_air_above_higher_altitudes(provider: Any, wavenumber_cm1: Array) -> None:
    """Above 6 km lies less than half of the air: optical depth falls, where it is measurable at the sea."""
    if not _in_range(provider, 6000.0) or not _in_range(provider, 0.0):
        raise Inapplicable("the provider's range of altitudes excludes the sea or 6 km")
    sea, high = provider.transmittance(wavenumber_cm1, [to_space(0.0, 0.0), to_space(6000.0, 0.0)])
    measurable = (sea > 1e-6) & (sea < 0.999)
    if not np.any(measurable):
        raise Inapplicable("the air is transparent or opaque at all wavenumbers")
    ratio = np.log(np.maximum(high[measurable], 1e-300)) / np.log(sea[measurable])
    at_most("optical depth above 6 km over that above the sea", np.mean(ratio), 0.85)


def grazing_paths_transmit_less(provider: Any, wavenumber_cm1: Array, tolerance: float = FRACTION_TOLERANCE) -> None:
    """T is in [0, 1], does not grow toward the horizon, and falls there where the vertical path absorbs."""
    low, high = provider.declares.valid.get("view_zenith", (0.0, 90.0))
    zenith = [angle for angle in (0.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.5) if low <= angle <= high]
    if len(zenith) < 2 or not _in_range(provider, 0.0):
        raise Inapplicable("the provider's range of zenith angles or altitudes is too small")
    through = provider.transmittance(wavenumber_cm1, [to_space(0.0, angle) for angle in zenith])
    near("T", through, 0.5, atol=0.5 + FRACTION_TOLERANCE)
    at_most("growth of T toward the horizon", np.diff(through, axis=0), tolerance)
    absorbs = (through[0] < 0.999) & (through[0] > 1e-6)
    if zenith[0] == 0.0 and np.any(absorbs):
        for slant, less, angle in zip(through[:-1], through[1:], zenith[1:], strict=True):
            measurable = absorbs & (slant > 1e-4)
            if np.any(measurable):
                change = float(np.max(less[measurable] / slant[measurable])) - 1.0
                at_most(f"relative growth of T toward zenith {angle:g} deg", change, -1e-5)


def air_ends_at_the_top_of_the_profile(provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array) -> None:
    """T = 1 above the uppermost level, and less than 1 where a ten-thousandth of the air is above.

    Altitudes in other units, or times a factor, show here.
    """
    profile = inputs.profile
    inside = float(np.interp(-np.log(1e-4 * profile.pressure_Pa[0]), -np.log(profile.pressure_Pa), profile.altitude_m))
    outside = 1.001 * float(profile.altitude_m[-1])
    if not (_in_range(provider, inside) and _in_range(provider, outside)):
        raise Inapplicable("the provider's range of altitudes ends lower")
    try:
        above, within, sea = provider.transmittance(wavenumber_cm1, [to_space(z, 0.0) for z in (outside, inside, 0.0)])
    except HcssError as error:
        raise Inapplicable(f"the provider refuses paths that begin above its air: {error}") from error
    near("T above the uppermost level", above, 1.0, atol=1e-12)
    if np.any(sea < 0.9):
        require(np.any(within < 1.0), f"T is 1 above {inside:g} m, where the air has not ended")


def declared_range_is_usable_to_its_ends(provider: Any) -> None:
    """The lowest and highest declared wavenumbers give transmittances."""
    ends = range_ends(provider.declares)
    result = provider.transmittance(ends, [to_space(0.0, 0.0)])
    near("T at the ends of the range", result, 0.5, atol=0.5)


def path_radiance_is_that_of_air_at_its_temperatures(
    provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
) -> None:
    """Between (1 - T) B of the coldest and of the warmest air of the leg; (1 - T) B of isothermal air."""
    if not hasattr(provider, "path_radiance"):
        raise Inapplicable(NO_PATH_RADIANCE)
    profile = inputs.profile
    for base, zenith in ((0.0, 0.0), (0.0, 60.0), (6000.0, 30.0)):
        leg = [to_space(base, zenith)]
        if not _in_range(provider, base):
            continue
        kelvin = np.append(profile.temperature_K[profile.altitude_m >= base], profile.temperature_at(base))
        emitted = 1.0 - provider.transmittance(wavenumber_cm1, leg)[0]
        radiance = provider.path_radiance(wavenumber_cm1, leg)[0]
        most, least = (
            emitted * planck(wavenumber_cm1, float(temperature_K)) for temperature_K in (kelvin.max(), kelvin.min())
        )
        at_most("path radiance, with that of air of the highest temperature,", radiance, 1.02 * most + 1e-9)
        at_least("path radiance, with that of air of the lowest temperature,", radiance, 0.98 * least - 1e-9)
    if provider.declares.legs == "any":
        warmest = planck(wavenumber_cm1, float(profile.temperature_K.max()))
        part = [Path((Leg(0.0, 2000.0, 30.0),))]
        most = (1.0 - provider.transmittance(wavenumber_cm1, part)) * warmest
        at_most("path radiance of the lowest 2 km", provider.path_radiance(wavenumber_cm1, part), 1.02 * most + 1e-9)


def low_air_shines_with_the_temperature_of_low_air(
    provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
) -> None:
    """Path radiance from the sea equals the sum over layers of B times the change of transmittance, within 10 %."""
    if not hasattr(provider, "path_radiance"):
        raise Inapplicable(NO_PATH_RADIANCE)
    levels = inputs.profile.altitude_m
    if not (_in_range(provider, float(levels[0])) and _in_range(provider, float(levels[-1]))):
        raise Inapplicable("the provider's range of altitudes is smaller than the profile")
    kelvin = inputs.profile.temperature_K
    sources = planck(wavenumber_cm1, 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
    for zenith in (0.0, 60.0):
        through = provider.transmittance(wavenumber_cm1, [to_space(float(level), zenith) for level in levels])
        expected = np.sum(np.diff(through, axis=0) * sources, axis=0)
        radiance = provider.path_radiance(wavenumber_cm1, [to_space(float(levels[0]), zenith)])[0]
        near(f"path radiance from the sea, zenith {zenith:g} deg,", radiance, expected, rtol=0.1, atol=1e-9)


def amounts_of_a_leg_crossed_twice_are_double(provider: Any) -> None:
    """Each crossing counts, where amounts are offered."""
    if not hasattr(provider, "absorber_amounts"):
        raise Inapplicable("the provider takes paths only")
    once, twice = provider.absorber_amounts([to_space(0.0, 30.0), to_space(0.0, 30.0) + to_space(0.0, 30.0)])
    near("amount of a leg crossed twice", twice, 2.0 * once, rtol=1e-9)


def no_more_sunlight_is_scattered_than_is_lost(provider: Any, wavenumber_cm1: Array) -> None:
    """Scattered sunlight is at most 1 - T of the way of the light, per steradian."""
    if not hasattr(provider, "solar_path_radiance"):
        raise Inapplicable("the provider scatters no sunlight")
    leg, sun = to_space(0.0, 30.0), to_space(0.0, 60.0)
    scattered = provider.solar_path_radiance(wavenumber_cm1, [leg], 60.0, 90.0)
    lost = 1.0 - provider.transmittance(wavenumber_cm1, [leg + sun])
    at_most("sunlight scattered per steradian", scattered, lost + 1e-3)


def amounts_add_over_legs_and_stand_for_paths(provider: Any, wavenumber_cm1: Array) -> None:
    """amounts(a + b) = amounts(a) + amounts(b), and T of amounts is T of their paths, where they are offered."""
    offered = [hasattr(provider, name) for name in ("absorber_amounts", "transmittance_of_amounts")]
    require(all(offered) == any(offered), "absorber_amounts and transmittance_of_amounts need each other")
    if not any(offered):
        raise Inapplicable("the provider takes paths only")
    first, second = to_space(0.0, 20.0), Path((Leg(500.0, 2500.0, 50.0),))
    paths = [first, second, first + second, Path()]
    one, other, both, none = provider.absorber_amounts(paths)
    near("amount of two legs", both, one + other, rtol=1e-9)
    near("amount of an empty path", none, 0.0)
    by_amounts = provider.transmittance_of_amounts(wavenumber_cm1, np.stack((one, other, both, none)))
    near("T of amounts", by_amounts, provider.transmittance(wavenumber_cm1, paths), rtol=1e-12, atol=1e-15)


LAWS: tuple[Law, ...] = (
    path_without_legs_transmits_everything,
    leg_without_length_transmits_everything,
    dividing_a_leg_changes_nothing,
    slant_path_at_60_degrees_is_the_vertical_path_twice,
    there_is_less_air_above_higher_altitudes,
    grazing_paths_transmit_less,
    air_ends_at_the_top_of_the_profile,
    path_radiance_is_that_of_air_at_its_temperatures,
    low_air_shines_with_the_temperature_of_low_air,
    amounts_of_a_leg_crossed_twice_are_double,
    amounts_add_over_legs_and_stand_for_paths,
    no_more_sunlight_is_scattered_than_is_lost,
    declared_range_is_usable_to_its_ends,
)


def _skip_without_legs(provider: Any) -> None:
    if provider.declares.legs == "to_space":
        raise Inapplicable("knows paths to space only")


def _in_range(provider: Any, altitude_m: float) -> bool:
    low, high = provider.declares.valid.get("target_altitude_m", (0.0, np.inf))
    return bool(low <= altitude_m <= high)
