"""Contract tests of sea models."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hcss_author.contract import NoMaker, SpectralContract, holds
from hcss_author.samples import frozen, sample_sea_inputs
from hcss_twin.laws import questions_of
from hcss_twin.providers import Array, Kind, SeaInputs, SeaModel

_MU_OUT, _MU_IN = frozen([1.0, 0.95, 0.9, 0.7, 0.5, 0.8]), frozen([0.9, 0.9, 0.5, 0.75, 0.5, 0.3])
_AZIMUTH = frozen([0.0, np.pi, 2.5, 3.0, np.pi, 1.0])


@holds(Kind.SEA)
class SeaModelContract(SpectralContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    reciprocity : float
        Relative difference allowed when sensor and source are exchanged.
    mean_over_bearings : float
        Allowed relative difference between results without a wind bearing and the mean over all bearings, for
        anisotropic models.
    """

    _kind = Kind.SEA
    reciprocity: float = 0.02
    mean_over_bearings: float = 0.01

    def make_provider(self, inputs: SeaInputs) -> SeaModel:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> SeaInputs:
        """Inputs; override to choose others."""
        return sample_sea_inputs()

    @pytest.fixture
    def questions(self, provider: SeaModel, wavenumber_cm1: Array) -> tuple[Any, ...]:
        """Directions, and others."""
        return questions_of(Kind.SEA, provider, None, wavenumber_cm1=wavenumber_cm1)

    def test_emissivity_shape_type_and_range(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """(M, V) of real numbers in [0, 1]."""
        self._guarded(provider).emissivity(wavenumber_cm1, _MU_OUT)

    def test_brdf_shape_type_and_range(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """(M, V) of real numbers, finite and not negative."""
        self._guarded(provider).brdf(wavenumber_cm1, _MU_OUT, _MU_IN, _AZIMUTH)

    def test_undeclared_directions_have_no_influence(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """Variables not in ``declares.depends_on`` do not change the result."""
        depends_on = provider.declares.depends_on
        if depends_on is None:
            pytest.skip("the model does not say on which variables it depends")
        if "view_zenith" not in depends_on:
            emissivity = provider.emissivity(wavenumber_cm1, _MU_OUT)
            np.testing.assert_array_equal(emissivity, np.broadcast_to(emissivity[:1], emissivity.shape))
        if "relative_azimuth" not in depends_on:
            one = provider.brdf(wavenumber_cm1, _MU_OUT, _MU_IN, _AZIMUTH)
            other = provider.brdf(wavenumber_cm1, _MU_OUT, _MU_IN, np.zeros(_AZIMUTH.size))
            np.testing.assert_array_equal(one, other)

    def test_result_does_not_depend_on_batching(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """Each direction and each wavenumber alone gives the same value as together."""
        emissivity = provider.emissivity(wavenumber_cm1, _MU_OUT)
        brdf = provider.brdf(wavenumber_cm1, _MU_OUT, _MU_IN, _AZIMUTH)
        for i in range(_MU_OUT.size):
            one = slice(i, i + 1)
            np.testing.assert_allclose(
                provider.emissivity(wavenumber_cm1, _MU_OUT[one])[0], emissivity[i], rtol=1e-10, atol=1e-15
            )
            alone = provider.brdf(wavenumber_cm1, _MU_OUT[one], _MU_IN[one], _AZIMUTH[one])
            np.testing.assert_allclose(alone[0], brdf[i], rtol=1e-10, atol=1e-15)
        for i in range(wavenumber_cm1.size):
            nu = wavenumber_cm1[i : i + 1]
            np.testing.assert_allclose(provider.emissivity(nu, _MU_OUT)[:, 0], emissivity[:, i], rtol=1e-10, atol=1e-15)
            alone = provider.brdf(nu, _MU_OUT, _MU_IN, _AZIMUTH)
            np.testing.assert_allclose(alone[:, 0], brdf[:, i], rtol=1e-10, atol=1e-15)

    def test_what_the_sky_sends_and_what_the_sea_emits_is_all(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """The reflection weights of a view sum to 1 - emissivity, where the model has them."""
        weights_of = getattr(provider, "reflection_weights", None)
        if weights_of is None:
            pytest.skip("the model has no reflection_weights")
        nodes = 0.5 * (np.polynomial.legendre.leggauss(8)[0] + 1.0)
        for basis in ("lagrange", "linear"):
            weights = weights_of(wavenumber_cm1, _MU_OUT, nodes, basis)
            assert weights.shape == (_MU_OUT.size, nodes.size, wavenumber_cm1.size)
            left = 1.0 - provider.emissivity(wavenumber_cm1, _MU_OUT)
            np.testing.assert_allclose(weights.sum(axis=1), left, rtol=0.0, atol=1e-9)
            if basis == "linear":
                assert weights.min() >= -1e-6
            for i in range(_MU_OUT.size):
                alone = weights_of(wavenumber_cm1, _MU_OUT[i : i + 1], nodes, basis)
                np.testing.assert_allclose(alone[0], weights[i], rtol=1e-10, atol=1e-15)
        np.testing.assert_array_equal(
            weights_of(wavenumber_cm1, _MU_OUT, nodes), weights_of(wavenumber_cm1, _MU_OUT, nodes, "lagrange")
        )

    def test_anisotropic_brdf_is_reciprocal_at_every_bearing(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """Exchanged directions are those of the mirror image, for a model that depends on the wind's bearing."""
        if not getattr(provider, "anisotropic", False):
            pytest.skip("the model does not depend on the bearing to the wind")
        model: Any = provider
        for bearing in (0.0, 1.0, 2.5, 4.0):
            wind = np.full(_AZIMUTH.size, bearing)
            one = model.brdf(wavenumber_cm1, _MU_OUT, _MU_IN, _AZIMUTH, wind)
            other = model.brdf(wavenumber_cm1, _MU_IN, _MU_OUT, _AZIMUTH, -(wind + _AZIMUTH))
            np.testing.assert_allclose(one, other, rtol=self.reciprocity, atol=1e-9)
            emissivity = model.emissivity(wavenumber_cm1, _MU_OUT, wind)
            assert np.all((emissivity >= 0.0) & (emissivity <= 1.0))

    def test_without_a_bearing_results_are_means_over_all(self, provider: SeaModel, wavenumber_cm1: Array) -> None:
        """Emissivity, BRDF and weights (M, N, V), for a model that depends on the wind's bearing."""
        if not getattr(provider, "anisotropic", False):
            pytest.skip("the model does not depend on the bearing to the wind")
        model: Any = provider
        nu, mu, nodes = wavenumber_cm1[:2], _MU_OUT[2:5:2], np.array([0.2, 0.5, 0.9])
        winds = np.arange(36) * (np.pi / 18.0)
        brdf = [model.brdf(nu, _MU_OUT, _MU_IN, _AZIMUTH, np.full(_MU_OUT.size, wind)) for wind in winds]
        self._assert_mean(brdf, model.brdf(nu, _MU_OUT, _MU_IN, _AZIMUTH))
        # Reflection of the whole sky is smooth in the bearing: six bearings have the mean of all.
        few = [np.full(mu.size, wind) for wind in winds[::6]]
        left = 1.0 - np.array([model.emissivity(nu, mu, wind) for wind in few])
        self._assert_mean(left, 1.0 - model.emissivity(nu, mu))
        if not hasattr(model, "reflection_weights"):
            return
        weights = np.array([model.reflection_weights(nu, mu, nodes, wind_azimuth=wind) for wind in few])
        assert weights.shape == (len(few), mu.size, nodes.size, nu.size)
        self._assert_mean(weights, model.reflection_weights(nu, mu, nodes))
        np.testing.assert_allclose(weights.sum(axis=2), left, rtol=0.0, atol=1e-9)

    def _assert_mean(self, at_bearings: Any, mean: Array) -> None:
        scale = self.mean_over_bearings * np.abs(mean).max()
        np.testing.assert_allclose(np.mean(at_bearings, axis=0), mean, rtol=self.mean_over_bearings, atol=scale)
