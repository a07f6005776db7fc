"""Laws of transmittance providers that need no reference: paths of no length, divided legs, slant and high paths."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hcss_twin.core.errors import HcssError
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import Array, AtmosphereInputs
from hcss_twin.testing.samples import range_ends

SLANT_TOLERANCE = 0.03
"""Allowed difference between the transmittance at 60 degrees and that of the vertical path crossed twice.

The air mass at 60 degrees is 1.99 to 2 on the round Earth; tabulated transmittances are interpolated.
"""

DIVISION_TOLERANCE = 2e-3
"""Allowed difference between a leg and its two parts; band models take means of pressure over parts of layers."""

NO_PATH_RADIANCE = "the engine derives path radiance from transmittance"


class TransmittanceLaws:
    """Laws of a transmittance provider; part of ``TransmittanceContract``."""

    def test_leg_without_length_transmits_everything(self, provider: Any, wavenumber_cm1: Array) -> None:
        """T = 1 for a leg that ends where it begins, for providers of any legs."""
        _skip_without_legs(provider)
        paths = [Path((Leg(500.0, 500.0, 30.0),)), Path((Leg(2000.0, 2000.0, 0.0),) * 2)]
        np.testing.assert_allclose(provider.transmittance(wavenumber_cm1, paths), 1.0, rtol=0, atol=1e-12)

    def test_dividing_a_leg_changes_nothing(self, provider: Any, wavenumber_cm1: Array) -> None:
        """T of a leg is that of its two parts as one path; the product of their transmittances is not."""
        _skip_without_legs(provider)
        for zenith in (0.0, 50.0):
            whole = to_space(0.0, zenith)
            parts = Path((Leg(0.0, 2000.0, zenith), Leg(2000.0, SPACE, zenith)))
            one, other = provider.transmittance(wavenumber_cm1, [whole, parts])
            np.testing.assert_allclose(other, one, rtol=0, atol=DIVISION_TOLERANCE)

    def test_slant_path_at_60_degrees_is_the_vertical_path_twice(self, provider: Any, wavenumber_cm1: Array) -> None:
        """The cosine is one half, so that the slant path holds twice the air."""
        low, high = provider.declares.valid.get("view_zenith", (0.0, 90.0))
        if low > 0.0 or high < 60.0:
            pytest.skip("the provider's range of zenith angles excludes 0 or 60 degrees")
        vertical = to_space(0.0, 0.0)
        slant, twice = provider.transmittance(wavenumber_cm1, [to_space(0.0, 60.0), vertical + vertical])
        np.testing.assert_allclose(slant, twice, rtol=0, atol=SLANT_TOLERANCE)

    def test_there_is_less_air_above_higher_altitudes(self, provider: Any, wavenumber_cm1: Array) -> None:
        """Above 6 km lies less than half of the air: optical depth falls, where it is measurable at the sea."""
        if not _in_range(provider, 6000.0) or not _in_range(provider, 0.0):
            pytest.skip("the provider's range of altitudes excludes the sea or 6 km")
        sea, high = provider.transmittance(wavenumber_cm1, [to_space(0.0, 0.0), to_space(6000.0, 0.0)])
        measurable = (sea > 1e-6) & (sea < 0.999)
        if not np.any(measurable):
            pytest.skip("the air is transparent or opaque at all wavenumbers")
        ratio = np.log(np.maximum(high[measurable], 1e-300)) / np.log(sea[measurable])
        assert np.mean(ratio) <= 0.85, f"optical depth above 6 km is {np.mean(ratio):.3g} of that above the sea"

    def test_air_ends_at_the_top_of_the_profile(
        self, provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
    ) -> None:
        """T = 1 above the uppermost level, and less than 1 where a ten-thousandth of the air is above.

        Altitudes in other units, or times a factor, show here.
        """
        profile = inputs.profile
        inside = float(
            np.interp(-np.log(1e-4 * profile.pressure_Pa[0]), -np.log(profile.pressure_Pa), profile.altitude_m)
        )
        outside = 1.001 * float(profile.altitude_m[-1])
        if not (_in_range(provider, inside) and _in_range(provider, outside)):
            pytest.skip("the provider's range of altitudes ends lower")
        try:
            above, within, sea = provider.transmittance(
                wavenumber_cm1, [to_space(z, 0.0) for z in (outside, inside, 0.0)]
            )
        except HcssError as error:
            pytest.skip(f"the provider refuses paths that begin above its air: {error}")
        np.testing.assert_allclose(above, 1.0, rtol=0, atol=1e-12)
        if np.any(sea < 0.9):
            assert np.any(within < 1.0), f"T = 1 above {inside:g} m, where the air has not ended"

    def test_declared_range_is_usable_to_its_ends(self, provider: Any) -> None:
        """The lowest and highest declared wavenumbers give transmittances."""
        ends = range_ends(provider.declares)
        result = provider.transmittance(ends, [to_space(0.0, 0.0)])
        assert np.all((result >= 0.0) & (result <= 1.0))

    def test_path_radiance_is_that_of_air_at_its_temperatures(
        self, provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
    ) -> None:
        """Between (1 - T) B of the coldest and of the warmest air of the leg; (1 - T) B of isothermal air."""
        if not hasattr(provider, "path_radiance"):
            pytest.skip(NO_PATH_RADIANCE)
        profile = inputs.profile
        for base, zenith in ((0.0, 0.0), (0.0, 60.0), (6000.0, 30.0)):
            leg = [to_space(base, zenith)]
            if not _in_range(provider, base):
                continue
            kelvin = np.append(profile.temperature_K[profile.altitude_m >= base], profile.temperature_at(base))
            emitted = 1.0 - provider.transmittance(wavenumber_cm1, leg)[0]
            radiance = provider.path_radiance(wavenumber_cm1, leg)[0]
            most, least = (emitted * planck(wavenumber_cm1, float(each)) for each in (kelvin.max(), kelvin.min()))
            assert np.all(radiance <= 1.02 * most + 1e-9), "brighter than air of the highest temperature"
            assert np.all(radiance >= 0.98 * least - 1e-9), "darker than air of the lowest temperature"
        if provider.declares.legs == "any":
            warmest = planck(wavenumber_cm1, float(profile.temperature_K.max()))
            part = [Path((Leg(0.0, 2000.0, 30.0),))]
            most = (1.0 - provider.transmittance(wavenumber_cm1, part)) * warmest
            assert np.all(provider.path_radiance(wavenumber_cm1, part) <= 1.02 * most + 1e-9), "leg of the lowest 2 km"

    def test_low_air_shines_with_the_temperature_of_low_air(
        self, provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
    ) -> None:
        """Path radiance from the sea equals the sum over layers of B times the change of transmittance, within 10 %."""
        if not hasattr(provider, "path_radiance"):
            pytest.skip(NO_PATH_RADIANCE)
        levels = inputs.profile.altitude_m
        if not (_in_range(provider, float(levels[0])) and _in_range(provider, float(levels[-1]))):
            pytest.skip("the provider's range of altitudes is smaller than the profile")
        kelvin = inputs.profile.temperature_K
        sources = planck(wavenumber_cm1, 0.5 * (kelvin[1:] + kelvin[:-1])[:, None])
        for zenith in (0.0, 60.0):
            through = provider.transmittance(wavenumber_cm1, [to_space(float(level), zenith) for level in levels])
            expected = np.sum(np.diff(through, axis=0) * sources, axis=0)
            radiance = provider.path_radiance(wavenumber_cm1, [to_space(float(levels[0]), zenith)])[0]
            np.testing.assert_allclose(radiance, expected, rtol=0.1, atol=1e-9)

    def test_amounts_of_a_leg_crossed_twice_are_double(self, provider: Any) -> None:
        """Each crossing counts, where amounts are offered."""
        if not hasattr(provider, "absorber_amounts"):
            pytest.skip("the provider takes paths only")
        once, twice = provider.absorber_amounts([to_space(0.0, 30.0), to_space(0.0, 30.0) + to_space(0.0, 30.0)])
        np.testing.assert_allclose(twice, 2.0 * once, rtol=1e-9, atol=0)

    def test_no_more_sunlight_is_scattered_than_is_lost(self, provider: Any, wavenumber_cm1: Array) -> None:
        """Scattered sunlight is at most 1 - T of the way of the light, per steradian."""
        if not hasattr(provider, "solar_path_radiance"):
            pytest.skip("the provider scatters no sunlight")
        leg, sun = to_space(0.0, 30.0), to_space(0.0, 60.0)
        scattered = provider.solar_path_radiance(wavenumber_cm1, [leg], 60.0, 90.0)
        assert np.all(scattered <= 1.0 - provider.transmittance(wavenumber_cm1, [leg + sun]) + 1e-3)


def _skip_without_legs(provider: Any) -> None:
    if provider.declares.legs == "to_space":
        pytest.skip("knows paths to space only")


def _in_range(provider: Any, altitude_m: float) -> bool:
    low, high = provider.declares.valid.get("target_altitude_m", (0.0, np.inf))
    return bool(low <= altitude_m <= high)
