"""Each cloud layer has optics of its own: ash above a water cloud above the sea follows its closed form."""

import json
from types import MappingProxyType

import numpy as np
import pytest
from cheap import CHEAP
from installed_providers import install
from pydantic import BaseModel
from refusals import problems_of

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.table_key import table_key
from hcss_twin.physics.planck import planck
from hcss_twin.plan.description import describe_particles
from hcss_twin.plan.optics import LayerOptics
from hcss_twin.providers import AtmosphereDeclaration, OpticsDeclaration, SingleScattering
from hcss_twin.providers.registry import ProviderSpec, hookimpl

ASH_K, CLOUD_K = 230.0, 280.0
ASH = {
    "type": "ash.toml", "coverage": 1.0, "coverage_mode": "field", "temperature": ASH_K,
    "optics": {"provider": "grey", "parameters": {"extinction": 2e-3}},
}  # fmt: skip
CLOUD = {
    "type": "paper-stratus", "coverage": 1.0, "coverage_mode": "field", "temperature": CLOUD_K,
    "thickness_min": 900.0, "optics": {"provider": "grey", "parameters": {"extinction": 1.0}},
}  # fmt: skip
BASE = {
    "time": "2024-04-20T22:30:00+10:00", "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 6, "columns": 8, "pixel_size": 200.0}, "frames": {"count": 1}, "bands": [[10.7, 10.9]],
    "atmosphere": {"profile": "us-standard-1976"},
    "output": {"variables": ["radiance", "truth"], "certificate": 8},
}  # fmt: skip
TYPE = """
title = "Ash"
description = "Volcanic ash"
source = "test"
[layer]
material = "ash"
base = 9000.0
top = 10000.0
thickness_min = 100.0
[fractal]
gamma = 3.0
H = 0.8
L = [10, 10]
k = [0, 4]
[microphysics]
effective_radius_um = 3.0
effective_variance = 0.2
water_content_kg_m3 = 1e-6
density = 2600.0
source = "test"
"""


class GreyParameters(BaseModel):
    """Extinction coefficient."""

    extinction: float = 1e-3


class Grey:
    """A grey absorber of ash or water."""

    expected_failures = MappingProxyType(
        {
            f"extinction is {law}": "the tests set it, so that a cloud is black or ash is thin"
            for law in ("that of particles of this size", "proportional to the number of particles")
        }
    )
    declares = OpticsDeclaration(materials=frozenset({"ash", "water"}), notes_by_material={"ash": ("ash is grey",)})

    def __init__(self, inputs, parameters):
        self.extinction = parameters.extinction

    def single_scattering(self, cloud, wavenumber_cm1):
        ones = np.ones(wavenumber_cm1.size)
        return SingleScattering(self.extinction * ones, 0.0 * ones, np.stack((ones, 0.0 * ones)))


class Vacuum:
    """Transparent air."""

    declares = AtmosphereDeclaration()

    def __init__(self, inputs, parameters):
        pass

    def transmittance(self, wavenumber_cm1, paths):
        return np.ones((len(paths), wavenumber_cm1.size))


class Plugin:
    @hookimpl
    def hcss_register_optics(self):
        return [ProviderSpec("grey", f"{__name__}:Grey", f"{__name__}:GreyParameters", 3, "grey")]

    @hookimpl
    def hcss_register_transmittance_providers(self):
        return [ProviderSpec("vacuum", f"{__name__}:Vacuum", None, 3, "transparent")]


@pytest.fixture
def folder(monkeypatch, tmp_path):
    install(monkeypatch, Plugin(), "grey")
    (tmp_path / "ash.toml").write_text(TYPE, encoding="utf-8")
    return tmp_path


def scenario(folder, *layers, **changes):
    return Scenario.from_dict({**BASE, "clouds": {"layers": list(layers)}}, {**CHEAP, **changes}, base=folder)


@pytest.mark.parametrize("model", ["as-printed", "physical"])
def test_ash_above_a_black_cloud_is_its_closed_form(folder, model):
    plan = make_plan(scenario(folder, CLOUD, ASH, **{"atmosphere.provider": "vacuum", "radiance.model": model}))
    frame = next(stream(plan, tables_of(plan)))
    depth = 2e-3 * frame["cloud_layer_thickness"][1].astype(float)
    through, grid = np.exp(-depth), plan.spectral_grid
    assert np.ptp(through) > 0.3
    ash, cloud = (grid.weights_cm1 @ planck(grid.wavenumber_cm1, kelvin) for kelvin in (ASH_K, CLOUD_K))
    expected = (1.0 - through) * ash[:, None, None] + through * cloud[:, None, None]
    np.testing.assert_allclose(frame["radiance"], expected, rtol=1e-3)
    np.testing.assert_allclose(
        frame["cloud_optical_thickness"][0], depth + frame["cloud_layer_thickness"][0], rtol=1e-6
    )
    np.testing.assert_array_equal(frame["cloud_top_temperature"], np.full(through.shape, ASH_K, np.float32))
    assert "ash is grey" in " ".join(plan.notes)
    about = describe_particles(plan.layers[1])
    assert about["material"] == "ash"
    # 1 mg m-3 of spheres of 3 um and 2600 kg m-3: 3 M / (2 rho r)
    assert about["large_particle_extinction_m1"] == pytest.approx(1.5e-6 / (2600.0 * 3e-6), rel=1e-3)


def test_optics_of_the_only_layer_are_those_of_the_scene(folder):
    own, section = dict(CLOUD), CLOUD["optics"]
    del own["optics"]
    whole = make_plan(scenario(folder, own, **{"optics.provider": "grey", "optics.parameters": section["parameters"]}))
    alone = make_plan(scenario(folder, CLOUD))
    assert alone.assembly.entries == whole.assembly.entries
    first, second = (next(stream(plan, tables_of(plan))) for plan in (whole, alone))
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])


def test_a_cube_of_ash_over_water_droplets_over_sea_passes_its_certificate(folder):
    cloud = {key: value for key, value in CLOUD.items() if key != "optics"} | {"coverage": 0.5}
    thin = {**ASH, "coverage": 0.5, "optics": {"provider": "grey"}}
    plan = make_plan(scenario(folder, cloud, thin))
    assert {each: entry.name for each, entry in plan.assembly.entries.items() if "optics" in each} == {
        "optics": "mie",
        "optics[1]": "grey",
    }
    with simulate(plan.scenario, folder / "cube.nc") as cube:
        assert cube.attrs["hcss_certificate"].startswith("computed as specified")
        assert [each["material"] for each in json.loads(cube.attrs["hcss_particles"])] == ["water", "ash"]
    again = make_plan(Scenario.from_cube(folder / "cube.nc", base=folder))
    assert json.loads(again.scenario.to_json()) == json.loads(plan.scenario.to_json())
    assert table_key(again) == table_key(plan)
    other = scenario(folder, cloud, {**thin, "optics": {"provider": "grey", "parameters": {"extinction": 2e-3}}})
    assert table_key(make_plan(other)) != table_key(plan)


def refused(folder, *layers, **changes):
    return problems_of(lambda: make_plan(scenario(folder, *layers, **changes)))


def test_a_material_that_the_provider_lacks_is_refused(folder):
    plain = {"type": "ash.toml"}
    said = refused(folder, plain)["clouds.layers[0].type"]
    assert "'ash' is what 'ash.toml' is made of" in said
    assert "allowed: ice, water" in said
    assert "clouds.layers[0].optics.provider" in said
    wrong = {**ASH, "material": "ice"}
    assert "allowed: ash, water" in refused(folder, wrong)["clouds.layers[0].material"]
    assert "density of 'ask' is unknown" in refused(folder, {**ASH, "material": "ask"})["clouds.layers[0].material"]


def test_an_unknown_provider_or_parameter_of_a_layer_is_named(folder):
    assert (
        "closest is 'grey'"
        in refused(folder, {**ASH, "optics": {"provider": "gray"}})["clouds.layers[0].optics.provider"]
    )
    wrong = {**ASH, "optics": {"provider": "grey", "parameters": {"extinction": "much"}}}
    assert "clouds.layers[0].optics.parameters.extinction" in refused(folder, wrong)


def test_equal_particles_have_one_optics(folder):
    low = {**ASH, "base": 5000.0, "top": 6000.0, "optics": {"provider": "grey"}}
    assert "equal particles" in refused(folder, low, ASH)["clouds.layers[1].optics.provider"]
    same = make_plan(scenario(folder, {**low, "optics": ASH["optics"]}, ASH))
    assert not isinstance(same.assembly.optics, LayerOptics)
