"""The kit accepts grey particles and refuses optics that break a law."""

import dataclasses

import numpy as np
import pytest
from hcss_author import OpticsContract, PlainOptics, sample_microphysics, sample_optics_inputs, sample_wavenumbers

from hcss_twin.providers import HcssError, OpticsDeclaration

REFUSED = (AssertionError, HcssError)
"""What laws raise, and the checks that a run makes of each result."""

NU = sample_wavenumbers(OpticsDeclaration())


class TestPlainOptics(OpticsContract):
    def make_provider(self, inputs):
        return PlainOptics()


@pytest.mark.parametrize(
    ("law", "change"),
    [
        ("ranges", {"albedo": lambda bulk: bulk.albedo + 0.5}),
        ("ranges", {"moments": lambda bulk: 1.01 * bulk.moments}),
        ("ranges", {"extinction_m1": lambda bulk: 0.0 * bulk.extinction_m1}),
        ("shapes", {"moments": lambda bulk: bulk.moments[:1]}),
        ("shapes", {"albedo": lambda bulk: bulk.albedo[:, None]}),
        (
            "extinction_is_proportional_to_the_number_of_particles",
            {"extinction_m1": lambda bulk: bulk.extinction_m1**2},
        ),
        ("result_does_not_depend_on_batching", {"albedo": lambda bulk: np.linspace(0, 1, bulk.albedo.size)}),
        ("scattering_cosine_has_a_variance", {"moments": lambda bulk: np.vstack((bulk.moments, 0.4 + 0 * NU))}),
        ("ranges", {"moments": lambda bulk: np.array([[1.0], [3.0]]) * bulk.moments}),
    ],
)
def test_kit_refuses_optics_that_break_a_law(law, change):
    class Broken(PlainOptics):
        def single_scattering(self, cloud, wavenumber_cm1):
            bulk = super().single_scattering(cloud, wavenumber_cm1)
            return dataclasses.replace(bulk, **{name: make(bulk) for name, make in change.items()})

    with pytest.raises(REFUSED):
        getattr(OpticsContract(), f"test_{law}")(Broken(), sample_microphysics(), NU)


@pytest.mark.parametrize("key", [lambda cloud: cloud.number_density_m3, lambda cloud: None])
def test_kit_refuses_optics_that_take_other_particles_for_the_same(key):
    class Remembers(PlainOptics):
        def __init__(self):
            super().__init__()
            self.known = {}

        def single_scattering(self, cloud, wavenumber_cm1):
            bulk = super().single_scattering(cloud, wavenumber_cm1)
            mine = dataclasses.replace(bulk, albedo=0.0 * bulk.albedo + min(1.0, 0.5 * cloud.b))
            return self.known.setdefault(key(cloud), mine)

    class Kit(OpticsContract):
        def make_provider(self, inputs):
            return Remembers()

    with pytest.raises(REFUSED):
        Kit().test_result_does_not_depend_on_earlier_calls(
            Remembers(), sample_optics_inputs(), sample_microphysics(), NU
        )


def test_kit_refuses_optics_without_a_declared_material():
    class Ash(PlainOptics):
        def __init__(self, *names):
            super().__init__()
            self.declares = OpticsDeclaration(materials=frozenset(names))

        def single_scattering(self, cloud, wavenumber_cm1):
            if cloud.material != "ash":
                raise ValueError(f"{cloud.material} is no ash")
            return super().single_scattering(cloud, wavenumber_cm1)

    kit = OpticsContract()
    kit.test_every_declared_material_has_properties(Ash("ash"), NU)
    with pytest.raises(ValueError, match="dust is no ash"):
        kit.test_every_declared_material_has_properties(Ash("ash", "dust"), NU)
