"""The kit accepts seas in closed form and refuses sea models that break a law."""

import numpy as np
import pytest
from hcss_author import PlainSea, SeaModelContract, sample_wavenumbers

from hcss_twin.providers import HcssError, SeaDeclaration

REFUSED = (AssertionError, HcssError)
"""What laws raise, and the checks that a run makes of each result."""

NU = sample_wavenumbers(SeaDeclaration())


class TestPlainSea(SeaModelContract):
    def make_provider(self, inputs):
        return PlainSea()


def fold(nu, mu, nodes, reflected=0.02):
    """The same share of every node's light in every view."""
    return np.full((mu.size, nodes.size, nu.size), reflected / nodes.size)


def broken_sea(**methods):
    sea = PlainSea()
    vars(sea).update(methods)
    return sea


@pytest.mark.parametrize(
    ("law", "methods"),
    [
        ("emissivity_shape_type_and_range", {"emissivity": lambda nu, mu: np.full((mu.size, nu.size), 1.01)}),
        ("emissivity_shape_type_and_range", {"emissivity": lambda nu, mu: np.full((nu.size, mu.size), 0.9)}),
        ("brdf_shape_type_and_range", {"brdf": lambda nu, out, into, az: np.full((out.size, nu.size), -0.1)}),
        ("brdf_is_reciprocal", {"brdf": lambda nu, out, into, az: out[:, None] * np.ones(nu.size)}),
        (
            "no_more_is_reflected_than_is_not_emitted",
            {"brdf": lambda nu, out, into, az: np.full((out.size, nu.size), 0.0069)},
        ),
        ("undeclared_directions_have_no_influence", {"emissivity": lambda nu, mu: mu[:, None] * np.ones(nu.size)}),
        ("undeclared_directions_have_no_influence", {"brdf": lambda nu, out, into, az: az[:, None] * np.ones(nu.size)}),
        (
            "result_does_not_depend_on_batching",
            {"emissivity": lambda nu, mu: mu[:, None] / mu.max() * np.ones(nu.size)},
        ),
        ("result_does_not_depend_on_batching", {"emissivity": lambda nu, mu: np.ones((mu.size, 1)) * (nu / nu.max())}),
        (
            "result_does_not_depend_on_batching",
            {"brdf": lambda nu, out, into, az: np.ones((out.size, 1)) * (nu / nu.max())},
        ),
        (
            "result_does_not_depend_on_batching",
            {"brdf": lambda nu, out, into, az: out[:, None] / out.max() * np.ones(nu.size)},
        ),
        ("what_is_not_emitted_is_reflected", {"emissivity": lambda nu, mu: np.full((mu.size, nu.size), 0.8)}),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="lagrange": fold(nu, mu, nodes, 0.021)},
        ),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="linear": fold(nu, mu, nodes, basis == "linear")},
        ),
        (
            "what_the_sky_sends_and_what_the_sea_emits_is_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="lagrange": fold(nu, mu, nodes).swapaxes(1, 2)},
        ),
    ],
)
def test_kit_refuses_a_sea_that_breaks_a_law(law, methods):
    with pytest.raises(REFUSED):
        getattr(SeaModelContract(), f"test_{law}")(broken_sea(**methods), NU)


class TiltedSea(PlainSea):
    """Emits and reflects more toward the wind than away from it."""

    anisotropic = True
    share = 0.2
    mean = 1.0

    def _turn(self, wind):
        return self.mean if wind is None else (1.0 + self.share * np.cos(wind))[:, None]

    def emissivity(self, nu, mu, wind_azimuth=None):
        return 1.0 - (1.0 - super().emissivity(nu, mu)) * self._turn(wind_azimuth)

    def brdf(self, nu, mu_out, mu_in, relative_azimuth, wind_azimuth=None):
        # the mean over both directions, so that exchanging them changes nothing
        both = (None, None) if wind_azimuth is None else (wind_azimuth, wind_azimuth + relative_azimuth)
        turn = 0.5 * (self._turn(both[0]) + self._turn(both[1]))
        return super().brdf(nu, mu_out, mu_in, relative_azimuth) * turn

    def reflection_weights(self, nu, mu, mu_nodes, basis="lagrange", wind_azimuth=None):
        left = 1.0 - self.emissivity(nu, mu, wind_azimuth)
        return np.repeat(left[:, None, :] / mu_nodes.size, mu_nodes.size, axis=1)


class TestTiltedSea(SeaModelContract):
    def make_provider(self, inputs):
        return TiltedSea()


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        ("without_a_bearing_results_are_means_over_all", {"mean": 1.3}),
        (
            "without_a_bearing_results_are_means_over_all",
            {"brdf": lambda nu, out, into, az, wind=None: np.full((out.size, nu.size), 1 if wind is None else 2)},
        ),
        (
            "without_a_bearing_results_are_means_over_all",
            {"reflection_weights": lambda nu, mu, nodes, basis="", wind_azimuth=None: fold(nu, mu, nodes)},
        ),
        (
            "anisotropic_brdf_is_reciprocal_at_every_bearing",
            {"brdf": lambda nu, out, into, az, wind: (2.0 + np.cos(wind))[:, None] * np.ones(nu.size)},
        ),
    ],
)
def test_kit_refuses_an_anisotropic_sea_that_breaks_a_law(law, changes):
    sea = TiltedSea()
    vars(sea).update(changes)
    with pytest.raises(REFUSED):
        getattr(SeaModelContract(), f"test_{law}")(sea, NU)
