import numpy as np
import pytest
from hcss_author import TransmittanceContract, assert_registered, sample_atmosphere_inputs
from hcss_grey_atmosphere.parameters import GreyParameters
from hcss_grey_atmosphere.provider import GreyAtmosphere

from hcss_twin.providers import to_space


class TestGreyAtmosphere(TransmittanceContract):
    def make_provider(self, inputs):
        return GreyAtmosphere(inputs, GreyParameters())


def test_is_found_when_installed():
    assert_registered("atmosphere", "grey", distribution="hcss-grey-atmosphere")


@pytest.mark.parametrize("depth", [0.0, 0.3, 5.0])
def test_vertical_column_has_the_given_depth(depth):
    provider = GreyAtmosphere(sample_atmosphere_inputs(), GreyParameters(optical_depth=depth))
    result = provider.transmittance(np.array([800.0, 2500.0]), [to_space(0.0, 0.0)])
    np.testing.assert_allclose(result, np.exp(-depth), rtol=1e-12)


def test_two_legs_multiply_because_the_gas_is_grey():
    provider = GreyAtmosphere(sample_atmosphere_inputs(), GreyParameters())
    up, down = to_space(0.0, 20.0), to_space(0.0, 50.0)
    one, other, both = provider.transmittance(np.array([1000.0]), [up, down, up + down])
    np.testing.assert_allclose(both, one * other, rtol=1e-12)
