"""Laws of optics providers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hcss_twin.providers import Array, Microphysics, Optics, OpticsInputs
from hcss_twin.providers.registry.declared import FRACTION_TOLERANCE, check_declares, check_options
from hcss_twin.testing.samples import sample_microphysics, sample_optics_inputs, sample_wavenumbers


class OpticsContract:
    """Inherit in a class named ``Test...`` and define ``make_provider``."""

    def make_provider(self, inputs: OpticsInputs) -> Optics:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> OpticsInputs:
        """Inputs; override to choose others."""
        return sample_optics_inputs()

    @pytest.fixture
    def provider(self, inputs: OpticsInputs) -> Optics:
        """Provider made from ``inputs``."""
        return self.make_provider(inputs)

    @pytest.fixture
    def cloud(self) -> Microphysics:
        """Particles to ask for; override for a provider of ice only."""
        return sample_microphysics("water")

    @pytest.fixture
    def wavenumber_cm1(self, provider: Optics) -> Array:
        """Wavenumbers to ask for; override to choose others."""
        return sample_wavenumbers(provider.declares)

    def test_declaration_is_sound(self, provider: Optics) -> None:
        """Names, ranges and optional attributes that the engine understands."""
        check_declares(provider.declares)
        check_options(provider)

    def test_shapes(self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
        """(V,), (V,) and (K, V) with K of at least 2, all real."""
        bulk = provider.single_scattering(cloud, wavenumber_cm1)
        size = wavenumber_cm1.size
        assert bulk.extinction_m1.shape == bulk.albedo.shape == (size,)
        assert bulk.moments.ndim == 2
        assert bulk.moments.shape[0] >= 2
        assert bulk.moments.shape[1] == size
        assert {bulk.extinction_m1.dtype.kind, bulk.albedo.dtype.kind, bulk.moments.dtype.kind} == {"f"}

    def test_ranges(self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array) -> None:
        """Extinction > 0, 0 <= albedo <= 1, moment 0 is 1, the others are above -1 and below 1."""
        bulk = provider.single_scattering(cloud, wavenumber_cm1)
        assert np.all(np.isfinite(bulk.extinction_m1))
        assert np.all(bulk.extinction_m1 > 0.0)
        assert np.all((bulk.albedo >= 0.0) & (bulk.albedo <= 1.0))
        np.testing.assert_allclose(bulk.moments[0], 1.0, rtol=0, atol=FRACTION_TOLERANCE)
        assert np.all(np.abs(bulk.moments[1:]) < 1.0)

    def test_scattering_cosine_has_a_variance(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Moment 2 is not below P_2 of moment 1: a mean of squares is not below the square of the mean.

        Moments that carry a factor 2k + 1, or are of another kind, show here.
        """
        moments = provider.single_scattering(cloud, wavenumber_cm1).moments
        if moments.shape[0] == 2:
            pytest.skip("Henyey-Greenstein: the asymmetry parameter is all there is")
        assert np.all(moments[2] >= 1.5 * moments[1] ** 2 - 0.5 - 1e-9)

    def test_extinction_is_proportional_to_the_number_of_particles(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Twice the particles: twice the extinction, the same albedo and phase function."""
        once = provider.single_scattering(cloud, wavenumber_cm1)
        double = dataclasses.replace(cloud, number_density_m3=2.0 * cloud.number_density_m3)
        twice = provider.single_scattering(double, wavenumber_cm1)
        np.testing.assert_allclose(twice.extinction_m1, 2.0 * once.extinction_m1, rtol=1e-9)
        np.testing.assert_allclose(twice.albedo, once.albedo, rtol=1e-9)
        np.testing.assert_allclose(twice.moments, once.moments, rtol=1e-9, atol=1e-12)

    def test_result_does_not_depend_on_batching(
        self, provider: Optics, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Some of the wavenumbers alone give what they give among others."""
        together = provider.single_scattering(cloud, wavenumber_cm1)
        some = provider.single_scattering(cloud, wavenumber_cm1[1::3])
        np.testing.assert_allclose(some.extinction_m1, together.extinction_m1[1::3], rtol=1e-10)
        np.testing.assert_allclose(some.albedo, together.albedo[1::3], rtol=1e-10)
        # the number of moments may follow the largest particle parameter asked for
        common = min(some.moments.shape[0], together.moments.shape[0])
        np.testing.assert_allclose(some.moments[:common], together.moments[:common, 1::3], rtol=1e-9, atol=1e-12)

    def test_result_does_not_depend_on_earlier_calls(
        self, provider: Optics, inputs: OpticsInputs, cloud: Microphysics, wavenumber_cm1: Array
    ) -> None:
        """Other particles asked for in between change nothing, and get their own answer."""
        other = dataclasses.replace(cloud, b=1.1 * cloud.b)
        before = provider.single_scattering(cloud, wavenumber_cm1)
        between = provider.single_scattering(other, wavenumber_cm1)
        after = provider.single_scattering(cloud, wavenumber_cm1)
        alone = self.make_provider(inputs).single_scattering(other, wavenumber_cm1)
        for name in ("extinction_m1", "albedo", "moments"):
            np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
            np.testing.assert_array_equal(getattr(between, name), getattr(alone, name))
