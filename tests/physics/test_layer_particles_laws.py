"""The particles a scenario gives a layer obey the optics of large droplets."""

import json

import numpy as np
import pytest
from cheap import CHEAP, CHEAP_OPTIONS, NARROW
from click.testing import CliRunner

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics.bulk import bulk_properties
from hcss_twin.models.refractive_index import load_refractive_index
from hcss_twin.plan.description import describe

TINY = {"image.rows": 8, "image.columns": 8, "frames.count": 1, "bands": NARROW[1:], **CHEAP}


def planned(**keys):
    return make_plan(Scenario.load("stratus", {**TINY, **{f"clouds.{key}": v for key, v in keys.items()}}))


@pytest.mark.parametrize(("radius", "content"), [(6.0, 0.2), (12.0, 0.3), (20.0, 0.5)])
def test_visible_extinction_is_three_halves_of_content_over_density_and_radius(radius, content):
    layer = planned(effective_radius=radius, effective_variance=0.1, water_content=content).layers[0]
    index = load_refractive_index(Catalog(), "water")
    found = bulk_properties(layer.microphysics, index, np.array([0.55]), 50).extinction_m1[0]
    limit = 1.5 * content * 1e-3 / (1000.0 * radius * 1e-6)
    assert limit < found < 1.08 * limit
    # Edge effect: H. M. Nussenzveig and W. J. Wiscombe, Phys. Rev. Lett. 45, 1490 (1980), Q = 2 + 1.9924 x^(-2/3).
    size = 2.0 * np.pi * radius / 0.55
    assert found == pytest.approx(limit * (1.0 + 0.9962 * size ** (-2.0 / 3.0)), rel=0.01)


def test_the_plan_tells_the_extinction_of_large_particles():
    told = describe(planned(effective_radius=12.0, water_content=0.3))["layers"][0]["particles"]
    assert told["large_particle_extinction_m1"] == pytest.approx(1.5 * 0.3e-3 / (1000.0 * 12e-6), rel=1e-4)
    assert (told["material"], told["effective_radius_um"]) == ("water", pytest.approx(12.0, rel=1e-5))
    given = ["--set", "clouds.effective_radius=12", "--set", 'bands=[{name="lwir", limits=[10.5, 11.0]}]']
    done = CliRunner().invoke(cli, ["plan", "stratus", "--verbose", *CHEAP_OPTIONS, *given])
    assert "stratus: water, effective radius 12 um, variance 0.129, 0.302 g m-3, extinction" in done.output


def test_a_cube_holds_the_particles_of_its_layers(tmp_path):
    overrides = {"clouds.effective_radius": 12.0, "output.variables": ["cloud_mask"]}
    with simulate(Scenario.load("stratus", {**TINY, **overrides}), tmp_path / "c.nc") as cube:
        (told,) = json.loads(cube.attrs["hcss_particles"])
        again = Scenario.from_cube(tmp_path / "c.nc")
    assert told["effective_radius_um"] == pytest.approx(12.0, rel=1e-5)
    assert again.clouds.layers[0].effective_radius == 12.0


def test_smaller_droplets_of_the_same_water_make_thicker_cloud(tmp_path):
    thickness = []
    for radius in (8.0, 16.0):
        scenario = {"clouds.effective_radius": radius, "output.variables": ["cloud_optical_thickness"]}
        with simulate(Scenario.load("stratus", {**TINY, **scenario}), tmp_path / f"{radius}.nc") as cube:
            thickness.append(float(cube["cloud_optical_thickness"].max()))
    assert 1.2 < thickness[0] / thickness[1] < 2.1
