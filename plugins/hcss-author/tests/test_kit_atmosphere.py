"""The kit accepts a grey gas and refuses transmittance providers that break a law."""

import numpy as np
import pytest
from hcss_author import PlainGas, TransmittanceContract, sample_atmosphere_inputs, sample_profile, sample_wavenumbers

from hcss_twin.providers import HcssError, to_space

REFUSED = (AssertionError, HcssError)
"""What laws raise, and the checks that a run makes of each result."""


class TestPlainGas(TransmittanceContract):
    def make_provider(self, inputs):
        return PlainGas(inputs.profile)


GAS_INPUTS = sample_atmosphere_inputs()
GAS = PlainGas(sample_profile())
NU = sample_wavenumbers(GAS.declares)


def broken_gas(transmittance):
    gas = PlainGas(sample_profile())
    honest = gas.transmittance
    gas.transmittance = lambda nu, paths: transmittance(honest, nu, paths)
    return gas


@pytest.mark.parametrize(
    ("law", "mistake"),
    [
        ("path_without_legs_transmits_everything", lambda honest, nu, paths: 0.99 * honest(nu, paths)),
        (
            "another_leg_never_transmits_more",
            lambda honest, nu, paths: np.array([[0.5 + 0.1 * len(p.legs)] * nu.size for p in paths]),
        ),
        ("longer_path_never_transmits_more", lambda honest, nu, paths: 1.0 - honest(nu, paths)),
        (
            "order_of_legs_does_not_matter",
            lambda honest, nu, paths: np.array([[0.5 + p.legs[0].zenith_deg / 200] * nu.size for p in paths]),
        ),
    ],
)
def test_kit_refuses_a_gas_that_breaks_a_law(law, mistake):
    kit = TransmittanceContract()
    with pytest.raises(REFUSED):
        getattr(kit, f"test_{law}")(broken_gas(mistake), NU)


def test_kit_refuses_a_gas_that_depends_on_its_batch_or_leaves_its_range():
    kit = TransmittanceContract()
    paths = [to_space(0.0, 0.0), to_space(0.0, 60.0)]
    relative = broken_gas(lambda honest, nu, paths: honest(nu, paths) / honest(nu, paths).max())
    with pytest.raises(REFUSED):
        kit.test_result_does_not_depend_on_batching(relative, NU, paths)
    with pytest.raises(REFUSED):
        kit.test_shape_type_and_range(broken_gas(lambda honest, nu, paths: 2.0 * honest(nu, paths)), NU, paths)
    with pytest.raises(REFUSED):
        kit.test_shape_type_and_range(broken_gas(lambda honest, nu, paths: honest(nu, paths).T), NU, paths)


def test_kit_refuses_path_radiance_brighter_than_the_air():
    gas = PlainGas(sample_profile())
    gas.path_radiance = lambda nu, paths: np.ones((len(paths), nu.size))
    with pytest.raises(REFUSED):
        TransmittanceContract().test_path_radiance_is_not_brighter_than_the_warmest_air(gas, GAS_INPUTS, NU)


def test_kit_refuses_a_gas_that_clears_higher_up():
    gas = broken_gas(
        lambda honest, nu, paths: np.where(
            [[any(5e3 < leg.upper_m < 6e4 for leg in path.legs)] for path in paths], 1.0, honest(nu, paths)
        )
    )
    with pytest.raises(REFUSED):
        TransmittanceContract().test_every_layer_of_air_only_takes_away(gas, GAS_INPUTS, NU)


def scattering_gas(scatter):
    gas = PlainGas(sample_profile())
    gas.solar_path_radiance = lambda nu, paths, sun_zenith_deg, relative_azimuth_deg: scatter(
        1.0 - gas.transmittance(nu, paths), nu, paths
    )
    return gas


def test_kit_accepts_a_gas_that_scatters_sunlight_in_proportion_to_its_depth():
    TransmittanceContract().test_scattered_sunlight_is_not_less_from_a_longer_leg(
        scattering_gas(lambda lost, nu, paths: 0.1 * lost), NU
    )


@pytest.mark.parametrize(
    "mistake",
    [
        lambda lost, nu, paths: 1.0 - lost,
        lambda lost, nu, paths: -lost,
        lambda lost, nu, paths: np.nan * lost,
        lambda lost, nu, paths: lost.T,
        lambda lost, nu, paths: lost / len(paths),
        lambda lost, nu, paths: lost / nu.size,
    ],
    ids=["less from longer legs", "negative", "not finite", "shape", "batch of paths", "batch of wavenumbers"],
)
def test_kit_refuses_scattered_sunlight_that_breaks_a_law(mistake):
    with pytest.raises(REFUSED):
        TransmittanceContract().test_scattered_sunlight_is_not_less_from_a_longer_leg(scattering_gas(mistake), NU)


@pytest.mark.parametrize("count", [lambda nu, paths: len(paths), lambda nu, paths: nu.size])
def test_kit_refuses_path_radiance_that_depends_on_its_batch(count):
    gas = PlainGas(sample_profile())
    gas.path_radiance = lambda nu, paths: np.full((len(paths), nu.size), 1e-6 / count(nu, paths))
    with pytest.raises(REFUSED):
        TransmittanceContract().test_path_radiance_does_not_depend_on_batching(gas, NU)


def gas_with_amounts(adding=lambda total, paths: total, law=lambda transmittance: transmittance):
    """Grey gas that offers its depth as an amount."""
    gas = PlainGas(sample_profile())
    gas.absorber_amounts = lambda paths: adding(-np.log(np.maximum(gas.transmittance(NU[:1], paths), 1e-300)), paths)
    gas.transmittance_of_amounts = lambda nu, amounts: law(np.exp(-np.repeat(amounts, nu.size, axis=1)))
    return gas


def test_kit_holds_amounts_to_sums_and_to_transmittances():
    kit = TransmittanceContract()
    kit.test_amounts_add_over_legs_and_stand_for_paths(gas_with_amounts(), NU)
    for broken in (
        gas_with_amounts(adding=lambda total, paths: total**2),
        gas_with_amounts(adding=lambda total, paths: total + 0.1),
        gas_with_amounts(law=lambda transmittance: 0.999 * transmittance),
    ):
        with pytest.raises(REFUSED):
            kit.test_amounts_add_over_legs_and_stand_for_paths(broken, NU)
    halved = gas_with_amounts()
    del halved.transmittance_of_amounts
    with pytest.raises(AssertionError, match="need each other"):
        kit.test_amounts_add_over_legs_and_stand_for_paths(halved, NU)
