"""The conformance kit, with the sample profile (a user's, without gases) and with a built-in atmosphere."""

import shutil

import numpy as np
import pytest
from hcss_author import TransmittanceContract, assert_registered
from hcss_lowtran7.parameters import Lowtran7Parameters
from hcss_lowtran7.provider import Lowtran7

from hcss_twin.providers import to_space

needs_gfortran = pytest.mark.skipif(shutil.which("gfortran") is None, reason="no gfortran: LOWTRAN7 cannot be compiled")


@needs_gfortran
class TestUserProfile(TransmittanceContract):
    # Rounding of the original's ray tracing.
    tolerance = 3e-4

    def make_provider(self, inputs):
        return Lowtran7(inputs, Lowtran7Parameters())


@needs_gfortran
class TestUserProfileDoublePrecision(TransmittanceContract):
    tolerance = 1e-7

    def make_provider(self, inputs):
        return Lowtran7(inputs, Lowtran7Parameters(precision="double"))


@needs_gfortran
class TestMaritimeBuiltIn(TransmittanceContract):
    tolerance = 3e-4

    @pytest.fixture
    def inputs(self, standard):
        return standard

    def make_provider(self, inputs):
        return Lowtran7(inputs, Lowtran7Parameters(aerosol="maritime", visibility_km=10))


def test_is_found_when_installed():
    assert_registered("atmosphere", "lowtran7", distribution="hcss-lowtran7")


def test_one_process_computes_a_batch_and_nothing_is_computed_twice(make, monkeypatch):
    import hcss_lowtran7.provider as module

    runs = []

    def counted(program, jobs, first, last):
        runs.append((len(jobs), first, last))
        return original(program, jobs, first, last)

    original = module.spectra
    monkeypatch.setattr(module, "spectra", counted)
    provider = make()
    view, sun = to_space(0.0, 20.0), to_space(0.0, 50.0)
    narrow, wide = np.array([1002.0, 1010.0]), np.array([900.0, 1010.0])
    provider.transmittance(narrow, [view, sun, view + sun, sun + view])
    provider.transmittance(narrow, [sun + view])
    assert runs == [(3, 1000.0, 1010.0)]
    provider.transmittance(wide, [view])
    provider.transmittance(narrow, [view])
    assert runs[1:] == [(1, 900.0, 1010.0)]
