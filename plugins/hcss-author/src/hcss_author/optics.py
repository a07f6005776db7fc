"""Contract tests of optics and transmittance providers."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Set
from functools import partial
from typing import Any

import numpy as np
import pytest

from hcss_author.contract import NoMaker, SpectralContract, holds
from hcss_author.samples import sample_atmosphere_inputs, sample_microphysics, sample_optics_inputs
from hcss_twin.laws import questions_of
from hcss_twin.providers import (
    Array,
    AtmosphereInputs,
    Kind,
    Leg,
    Microphysics,
    Optics,
    OpticsDeclaration,
    OpticsInputs,
    Path,
    TransmittanceProvider,
    planck,
    to_space,
)


@holds(Kind.OPTICS)
class OpticsContract(SpectralContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``."""

    _kind = Kind.OPTICS

    def make_provider(self, inputs: OpticsInputs) -> Optics:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> OpticsInputs:
        """Inputs; override to choose others."""
        return sample_optics_inputs()

    @pytest.fixture
    def cloud(self, provider: Optics) -> Microphysics:
        """Sample particles of water, or of the first material of a provider without water."""
        return sample_microphysics(min(materials(provider), key=lambda name: (name != "water", name)))

    @pytest.fixture
    def questions(self, cloud: Microphysics, wavenumber_cm1: Array) -> tuple[Any, ...]:
        """Particles, and smaller ones."""
        return questions_of(Kind.OPTICS, None, None, wavenumber_cm1=wavenumber_cm1, cloud=cloud)

    def test_every_declared_material_has_properties(self, provider: Optics, wavenumber_cm1: Array) -> None:
        """Sample particles of each declared material give properties at one wavenumber."""
        for material in sorted(materials(provider)):
            bulk = provider.single_scattering(sample_microphysics(material), wavenumber_cm1[:1])
            assert bulk.extinction_m1.shape == (1,), material

    def test_shapes(self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
        """(V,), (V,) and (K, V) with K of at least 2, all real."""
        self._guarded(provider).single_scattering(cloud, wavenumber_cm1)

    def test_ranges(self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
        """Extinction > 0, 0 <= albedo <= 1, moment 0 is 1, the others are above -1 and below 1."""
        bulk = self._guarded(provider).single_scattering(cloud, wavenumber_cm1)
        assert np.all(bulk.extinction_m1 > 0.0)

    def test_result_does_not_depend_on_batching(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """A subset of the wavenumbers gives the same values as the full set."""
        together = provider.single_scattering(cloud, wavenumber_cm1)
        some = provider.single_scattering(cloud, wavenumber_cm1[1::3])
        np.testing.assert_allclose(some.extinction_m1, together.extinction_m1[1::3], rtol=1e-10)
        np.testing.assert_allclose(some.albedo, together.albedo[1::3], rtol=1e-10)
        # the number of moments may depend on the largest particle parameter of a call
        common = min(some.moments.shape[0], together.moments.shape[0])
        np.testing.assert_allclose(some.moments[:common], together.moments[:common, 1::3], rtol=1e-9, atol=1e-12)

    def test_result_does_not_depend_on_earlier_calls(
        self, provider: Optics, inputs: OpticsInputs, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """A call for other particles in between does not change the result."""
        other = dataclasses.replace(cloud, b=1.1 * cloud.b)
        before = provider.single_scattering(cloud, wavenumber_cm1)
        between = provider.single_scattering(other, wavenumber_cm1)
        after = provider.single_scattering(cloud, wavenumber_cm1)
        alone = self.make_provider(inputs).single_scattering(other, wavenumber_cm1)
        for name in ("extinction_m1", "albedo", "moments"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
            np.testing.assert_array_equal(getattr(between, name), getattr(alone, name))


def materials(provider: Optics) -> Set[str]:
    """Return the declared materials; a provider of version 1 has water and ice."""
    found: Set[str] = getattr(provider.declares, "materials", OpticsDeclaration().materials)
    return found


@holds(Kind.ATMOSPHERE)
class TransmittanceContract(SpectralContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    tolerance : float
        Allowed increase of transmittance with path length, for providers that interpolate.
    sunlight_tolerance : float
        Allowed relative decrease of scattered sunlight with leg length, for providers that sum over layers.
    """

    _kind = Kind.ATMOSPHERE
    tolerance: float = 1e-9
    sunlight_tolerance: float = 0.005

    def make_provider(self, inputs: AtmosphereInputs) -> TransmittanceProvider:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> AtmosphereInputs:
        """Inputs; override for a provider that works with certain profiles only."""
        return sample_atmosphere_inputs()

    @pytest.fixture
    def paths(self) -> list[Path]:
        """Single and composite paths, from the sea and from a cloud top, as used by the engine."""
        single = [to_space(base, zenith) for base in (0.0, 1500.0) for zenith in (0.0, 30.0, 60.0)]
        return [*single, single[1] + single[2], single[5] + single[3]]

    @pytest.fixture
    def questions(self, provider: Any, wavenumber_cm1: Array) -> tuple[Any, ...]:
        """Paths, and others."""
        return questions_of(Kind.ATMOSPHERE, provider, None, wavenumber_cm1=wavenumber_cm1)

    def test_shape_type_and_range(self, provider: Any, wavenumber_cm1: Array, paths: list[Path]) -> None:
        """(P, V) of real numbers in [0, 1]."""
        self._guarded(provider).transmittance(wavenumber_cm1, paths)

    def test_another_leg_never_transmits_more(self, provider: Any, wavenumber_cm1: Array) -> None:
        """T(a + b) <= min(T(a), T(b))."""
        for base in (0.0, 1500.0):
            first, second = to_space(base, 20.0), to_space(base, 50.0)
            one, other, both = provider.transmittance(wavenumber_cm1, [first, second, first + second])
            assert np.all(both <= np.minimum(one, other) + self.tolerance)

    def test_longer_path_never_transmits_more(self, provider: Any, wavenumber_cm1: Array) -> None:
        """T does not grow with zenith angle, nor when the path begins lower."""
        slants = provider.transmittance(wavenumber_cm1, [to_space(0.0, zenith) for zenith in (0, 25, 50, 70)])
        assert np.all(np.diff(slants, axis=0) <= self.tolerance)
        heights = provider.transmittance(wavenumber_cm1, [to_space(base, 30) for base in (0, 500, 2000, 6000)])
        assert np.all(np.diff(heights, axis=0) >= -self.tolerance)

    def test_every_layer_of_air_only_takes_away(
        self, provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
    ) -> None:
        """T does not grow as a leg is extended upward, level by level, for providers of any legs."""
        if provider.declares.legs == "to_space":
            pytest.skip("knows paths to space only")
        levels = inputs.profile.altitude_m
        paths = [Path((Leg(0.0, float(level), 40.0),)) for level in levels[1:]]
        result = provider.transmittance(wavenumber_cm1, [*paths, to_space(0.0, 40.0)])
        assert np.all(np.diff(result, axis=0) <= self.tolerance)

    def test_order_of_legs_does_not_matter(self, provider: Any, wavenumber_cm1: Array) -> None:
        """Absorber amounts add, and addition commutes."""
        first, second = to_space(0.0, 20.0), to_space(0.0, 50.0)
        one, other = provider.transmittance(wavenumber_cm1, [first + second, second + first])
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=0)

    def test_result_does_not_depend_on_batching(self, provider: Any, wavenumber_cm1: Array, paths: list[Path]) -> None:
        """Each path and each wavenumber alone gives the same value as together."""
        together = provider.transmittance(wavenumber_cm1, paths)
        one_by_one = np.concatenate([provider.transmittance(wavenumber_cm1, [path]) for path in paths])
        np.testing.assert_allclose(one_by_one, together, rtol=1e-12, atol=1e-15)
        columns = [provider.transmittance(wavenumber_cm1[i : i + 1], paths) for i in range(wavenumber_cm1.size)]
        np.testing.assert_allclose(np.concatenate(columns, axis=1), together, rtol=1e-10, atol=1e-15)

    def test_path_radiance_is_not_brighter_than_the_warmest_air(
        self, provider: Any, inputs: AtmosphereInputs, wavenumber_cm1: Array
    ) -> None:
        """0 <= path radiance <= (1 - T) B(warmest level), where the provider has its own path radiance."""
        if not hasattr(provider, "path_radiance"):
            pytest.skip("the engine derives path radiance from transmittance")
        legs = [to_space(base, zenith) for base in (0.0, 1500.0) for zenith in (0.0, 60.0)]
        radiance = provider.path_radiance(wavenumber_cm1, legs)
        assert radiance.shape == (len(legs), wavenumber_cm1.size)
        warmest = planck(wavenumber_cm1, float(inputs.profile.temperature_K.max()))
        transmittance = provider.transmittance(wavenumber_cm1, legs)
        assert np.all(radiance >= 0.0)
        assert np.all(radiance <= (1.0 - transmittance) * warmest * 1.001 + 1e-12)

    def test_path_radiance_does_not_depend_on_batching(self, provider: Any, wavenumber_cm1: Array) -> None:
        """Each leg and a subset of the wavenumbers alone give the same values as together."""
        if not hasattr(provider, "path_radiance"):
            pytest.skip("the engine derives path radiance from transmittance")
        legs = [to_space(base, zenith) for base in (0.0, 1500.0) for zenith in (0.0, 60.0)]
        _same_in_parts(provider.path_radiance, wavenumber_cm1, legs)

    def test_scattered_sunlight_is_not_less_from_a_longer_leg(self, provider: Any, wavenumber_cm1: Array) -> None:
        """0 <= solar path radiance, not falling as the leg begins lower, where the provider has it."""
        if not hasattr(provider, "solar_path_radiance"):
            pytest.skip("the provider scatters no sunlight")
        legs = [to_space(base, 30.0) for base in (6000.0, 2000.0, 500.0, 0.0)]
        for sun_zenith_deg, relative_azimuth_deg in ((20.0, 0.0), (60.0, 180.0), (80.0, 90.0)):
            sun = sun_zenith_deg, relative_azimuth_deg
            result = provider.solar_path_radiance(wavenumber_cm1, legs, *sun)
            assert result.shape == (len(legs), wavenumber_cm1.size)
            assert np.all(np.isfinite(result))
            assert np.all(result >= 0.0)
            assert np.all(np.diff(result, axis=0) >= -self.sunlight_tolerance * result.max(axis=0))
            scattered = partial(provider.solar_path_radiance, sun_zenith_deg=sun[0], relative_azimuth_deg=sun[1])
            _same_in_parts(scattered, wavenumber_cm1, legs)


def _same_in_parts(radiance: Callable[[Array, list[Path]], Array], wavenumber_cm1: Array, legs: list[Path]) -> None:
    together = radiance(wavenumber_cm1, legs)
    one_by_one = np.concatenate([radiance(wavenumber_cm1, [leg]) for leg in legs])
    np.testing.assert_allclose(one_by_one, together, rtol=1e-10, atol=1e-15)
    columns = [radiance(wavenumber_cm1[i : i + 1], legs) for i in range(wavenumber_cm1.size)]
    np.testing.assert_allclose(np.concatenate(columns, axis=1), together, rtol=1e-10, atol=1e-15)
