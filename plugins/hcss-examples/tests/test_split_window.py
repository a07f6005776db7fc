"""Split window: the kit, and bands that do not exist."""

import pytest
from hcss_author import VariableContract, assert_registered, sample_variable_inputs
from hcss_examples.split_window import Parameters, SplitWindow

from hcss_twin.providers import ProviderError


class TestSplitWindow(VariableContract):
    def make_provider(self, inputs):
        return SplitWindow(inputs, Parameters(bands=("mid", "long")))


def test_is_found_when_installed():
    assert_registered("variables", "split-window", distribution="hcss-examples")


def test_a_band_that_is_not_there_is_named():
    with pytest.raises(ProviderError, match="split-window: bands has 'lwir'; allowed: long, mid"):
        SplitWindow(sample_variable_inputs(), Parameters(bands=("mid", "lwir")))
