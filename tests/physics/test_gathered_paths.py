"""Paths gathered for a provider that knows paths only: the radiance of one call for each leg, in few calls."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import PlainGas, sample_high_layer, sample_layer, sample_profile

from hcss_twin.laws.radiance import LawScene
from hcss_twin.laws.samples import sample_radiance_inputs
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical import gathered_paths, setting_columns
from hcss_twin.models.radiance.physical.model import Physical, PhysicalTwoStream
from hcss_twin.providers import Sun

NU = np.linspace(900.0, 2600.0, 9)
THICKNESS = np.array([[80.0, 0.0], [0.0, 500.0], [300.0, 900.0], [780.0, 1900.0], [80.0, 1200.0]])
PARAMETERS = PhysicalParameters(streams=4, sun_streams=4, azimuth_modes=4)


class CountedGas(PlainGas):
    def __init__(self, thread_safe=False):
        super().__init__(sample_profile())
        self.calls, self.thread_safe = 0, thread_safe

    def transmittance(self, wavenumber_cm1, paths):
        self.calls += 1
        return super().transmittance(wavenumber_cm1, paths) ** (1.0 + wavenumber_cm1 / 4000.0)


def scene(of, gas, *layers):
    inputs = sample_radiance_inputs(layers=layers)
    inputs = replace(inputs, setting=replace(inputs.setting, transmittance=gas))
    return LawScene(of(inputs, PARAMETERS), inputs.setting)


def radiance(of, gas, sun):
    made = scene(of, gas, sample_layer(), sample_high_layer())
    terms = made.cloudy(NU, THICKNESS, sun), made.clear(NU, sun)
    return [np.stack(list(each.values())) for each in terms]


@pytest.mark.parametrize("sun", [None, Sun(40.0, 200.0, 1.0)])
@pytest.mark.parametrize("of", [PhysicalTwoStream, Physical])
def test_radiance_is_that_of_one_call_for_each_leg_and_the_calls_are_few(of, sun, monkeypatch):
    few, safe = CountedGas(), CountedGas(thread_safe=True)
    gathered, in_threads = radiance(of, few, sun), radiance(of, safe, sun)
    monkeypatch.setattr(gathered_paths, "GATHERS", False)
    many = CountedGas()
    for one, other, threaded in zip(radiance(of, many, sun), gathered, in_threads, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-18)
        np.testing.assert_allclose(threaded, one, rtol=1e-12, atol=1e-18)
    assert few.calls == 2
    assert safe.calls == 2 * gathered_paths.BLOCKS
    assert many.calls > 20 * few.calls


def test_little_memory_means_more_calls_and_the_same_radiance(monkeypatch):
    usual = radiance(PhysicalTwoStream, CountedGas(), None)
    monkeypatch.setattr(gathered_paths, "MOST_VALUES", 2000)
    monkeypatch.setattr(setting_columns, "MOST_GATHERED", 2000)
    scarce = CountedGas()
    for one, other in zip(usual, radiance(PhysicalTwoStream, scarce, None), strict=True):
        np.testing.assert_array_equal(one, other)
    assert scarce.calls > 2


def test_a_known_spectrum_asks_for_nothing_twice():
    gas = CountedGas()
    made = scene(PhysicalTwoStream, gas, sample_layer())
    made.cloudy(NU, THICKNESS[2:, :1], None)
    before = gas.calls
    made.cloudy(NU, THICKNESS[2:3, :1], None)
    assert gas.calls == before
