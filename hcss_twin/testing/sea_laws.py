"""Laws of sea models that need no reference: closure by direction, the side of the glint, sizes of waves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hcss_twin.providers import Array, SeaInputs, SeaModel
from hcss_twin.testing.samples import range_ends

LEAST_REFLECTED = 0.7
"""Integral of the BRDF at least, over 1 - emissivity; facet models lose light that is reflected twice."""


class SeaLaws:
    """Laws of a sea model; part of ``SeaModelContract``."""

    def test_albedo_and_emissivity_sum_to_one(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """What is not emitted toward a direction is reflected there, within 30 % of it."""
        for view in (1.0, 0.8, 0.6):
            left = 1.0 - provider.emissivity(wavenumber_cm1, np.array([view]))[0]
            reflected = hemispherical_integral(provider, wavenumber_cm1, view)[0]
            assert np.all(reflected >= LEAST_REFLECTED * left - 1e-6), f"at mu = {view}: {reflected} of {left}"

    def test_sea_emits_most_upward(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """Emissivity at the zenith is not below that near the horizon, and differs if it depends on the view."""
        zenith, slant, horizon = provider.emissivity(wavenumber_cm1, np.array([1.0, 0.6, 0.25]))
        assert np.all(zenith >= horizon - 1e-9)
        if "view_zenith" in (provider.declares.depends_on or ()):
            assert np.any(zenith != horizon), "declares view_zenith, which does not matter"
        if np.any(zenith != horizon):
            assert np.all(slant >= horizon - 1e-9)

    def test_sunlight_is_reflected_to_the_side_of_the_glint(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """At equal zenith angles the BRDF is greatest at relative azimuth pi, if it depends on the azimuth."""
        declared = provider.declares.depends_on
        azimuth = np.linspace(0.0, np.pi, 9)
        mu = np.full(azimuth.size, 0.6)
        brdf = provider.brdf(wavenumber_cm1, mu, mu, azimuth)
        if "relative_azimuth" not in declared if declared is not None else np.all(brdf == brdf[0]):
            pytest.skip("the BRDF does not depend on the azimuth")
        assert np.all(brdf[-1] > 1.05 * brdf[:-2].max(axis=0)), "the glint is elsewhere"

    def test_weights_see_the_sky_that_the_brdf_sees(self, provider: Any, wavenumber_cm1: Array) -> None:
        """The mean cosine of reflected light is the same by the weights and by the BRDF, within 0.2."""
        if not hasattr(provider, "reflection_weights"):
            pytest.skip("the model has no reflection_weights")
        views, nodes = np.array([1.0, 0.6]), 0.5 * (np.polynomial.legendre.leggauss(8)[0] + 1.0)
        weights = provider.reflection_weights(wavenumber_cm1, views, nodes)
        by_weights = np.einsum("mnv,n->mv", weights, nodes) / weights.sum(axis=1)
        for row, view in enumerate(views.tolist()):
            total, moment = hemispherical_integral(provider, wavenumber_cm1, view)
            np.testing.assert_allclose(by_weights[row], moment / np.maximum(total, 1e-300), rtol=0, atol=0.2)

    def test_waves_are_of_a_sea(self, provider: Any, inputs: SeaInputs) -> None:
        """Mean square slope and significant wave height are not above three times those of usual seas, if given."""
        wind = inputs.wind_speed_m_s
        slope = getattr(provider, "mean_square_slope", 0.0)
        assert slope <= 3.0 * (0.003 + 0.00512 * wind), f"mean square slope {slope:g}"
        height = getattr(provider, "significant_wave_height_m", 0.0)
        assert height <= 3.0 * (0.1 + 0.025 * wind**2), f"significant wave height {height:g} m"

    def test_declared_range_is_usable_to_its_ends(self, provider: SeaModel) -> None:
        """The lowest and highest declared wavenumbers give emissivity and BRDF."""
        ends, mu = range_ends(provider.declares), np.array([0.8])
        assert np.all(np.isfinite(provider.emissivity(ends, mu)))
        assert np.all(np.isfinite(provider.brdf(ends, mu, mu, np.array([np.pi]))))


def hemispherical_integral(provider: SeaModel, wavenumber_cm1: Array, view: float) -> tuple[Array, Array]:
    """Return the integrals of BRDF times mu, and times mu squared, over the hemisphere, each (V,)."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    mu, mu_weight = (nodes + 1.0) / 2.0, weights / 2.0
    azimuth = (np.arange(96) + 0.5) * np.pi / 96
    grid_mu, grid_azimuth = (each.ravel() for each in np.meshgrid(mu, azimuth, indexing="ij"))
    share = np.repeat(mu_weight * 2.0 * np.pi / azimuth.size, azimuth.size) * grid_mu
    kernel = provider.brdf(wavenumber_cm1, np.full(grid_mu.size, view), grid_mu, grid_azimuth)
    return share @ kernel, (share * grid_mu) @ kernel
