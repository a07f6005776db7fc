"""The providers that ``hcss new-plugin`` writes are held to the kit."""

from importlib import import_module

import hcss_author
import numpy as np
from hcss_author import sample_microphysics, sample_optics_inputs
from hcss_author.new_plugin.write import contract_name

from hcss_twin.providers.registry import Kind


def template(kind):
    return import_module(f"hcss_author.new_plugin.templates.{kind}")


def contract_of(kind):
    def make_provider(self, inputs):
        module = template(kind)
        return module.Provider(inputs, module.Parameters())

    return type(f"Test{kind.title()}", (getattr(hcss_author, contract_name(kind)),), {"make_provider": make_provider})


globals().update({f"Test{kind.title()}": contract_of(kind) for kind in Kind})


def test_particles_of_the_template_have_twice_their_geometric_cross_section():
    module = template(Kind.OPTICS)
    cloud = sample_microphysics("water")
    bulk = module.Provider(sample_optics_inputs(), module.Parameters()).single_scattering(cloud, np.array([1000.0]))
    mean_square_um2 = 8 * 7 / cloud.b**2  # of the gamma distribution r^6 exp(-b r)
    expected = 2 * np.pi * mean_square_um2 * 1e-12 * cloud.number_density_m3
    np.testing.assert_allclose(bulk.extinction_m1, expected, rtol=1e-4)
