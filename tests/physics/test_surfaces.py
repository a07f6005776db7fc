"""Radiance over land follows closed forms: emission and reflection of a Lambertian surface below the air."""

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from hcss_author import PlainGas, PlainOptics, SeaModelContract, sample_profile
from scipy.special import expn
from surface_files import write_half

from hcss_twin import Scenario, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.laws.radiance import LawScene
from hcss_twin.laws.samples import flat_sun
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.model import Physical
from hcss_twin.models.surfaces.materials import material
from hcss_twin.physics import quadrature
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.planck import planck
from hcss_twin.plan.axis import PlacedAxis
from hcss_twin.plan.surfaces import temperature_axis
from hcss_twin.providers import ColumnSetting, RadianceInputs, Sun, View

WAVENUMBER = np.linspace(750.0, 3600.0, 9)


def columns(surface, depth, kelvin, view_deg=40.0, space=0.0):
    profile = sample_profile(280.0)
    setting = ColumnSetting(
        view=View(view_deg, 90.0),
        sun=None,
        sea=surface,
        sea_temperature_K=kelvin,
        profile=profile,
        transmittance=PlainGas(profile, depth),
        layers=(),
    )
    inputs = RadianceInputs(setting, PlainOptics(), flat_sun)
    return LawScene(Physical(inputs, PhysicalParameters(space_temperature=space)), setting)


def total(scene, sun=None):
    return np.sum(list(scene.clear(WAVENUMBER, sun).values()), axis=0)


@pytest.mark.parametrize("name", ["land", "sand", "snow", "ice"])
def test_in_transparent_air_a_surface_emits_and_reflects_the_sun_as_a_lambertian(name):
    """L = e B(T) + (1 - e) mu0 E0 / pi, in every direction."""
    surface = material(name, Catalog())
    table = Catalog().columns(Catalog().find("emissivity", "surfaces", ".csv"))
    emissivity = np.interp(1e4 / WAVENUMBER, table["wavelength_um"], table[name])
    for view_deg in (0.0, 40.0, 70.0):
        scene = columns(surface, 0.0, 300.0, view_deg)
        emitted = emissivity * planck(WAVENUMBER, 300.0)
        np.testing.assert_allclose(total(scene), emitted, rtol=1e-9)
        reflected = (1.0 - emissivity) * np.cos(np.radians(50.0)) * 0.01 / np.pi
        np.testing.assert_allclose(total(scene, Sun(50.0, 200.0, 1.0)), emitted + reflected, rtol=1e-9)


def test_below_isothermal_air_a_surface_reflects_the_flux_of_the_sky():
    """L = t e B + (1 - t) B_air + t (1 - e) (1 - 2 E3(tau)) B_air; exactly B in an enclosure of one temperature."""
    surface, depth = material("sand", Catalog()), 0.4
    emissivity = surface.emissivity(WAVENUMBER, np.ones(1))[0]
    through, air = np.exp(-depth / np.cos(np.radians(40.0))), planck(WAVENUMBER, 280.0)
    sky = 1.0 - 2.0 * expn(3, depth)
    expected = (
        through * emissivity * planck(WAVENUMBER, 305.0) + (1.0 - through * (1.0 - (1.0 - emissivity) * sky)) * air
    )
    np.testing.assert_allclose(total(columns(surface, depth, 305.0)), expected, rtol=1e-3)
    np.testing.assert_allclose(total(columns(surface, depth, 280.0, space=280.0)), air, rtol=1e-9)


def test_a_land_pixel_of_a_scene_emits_at_its_temperature_through_the_air(tmp_path):
    """Band radiance of a pixel less that of the sea alone, from the transmittance and the table of emissivity."""
    write_half(tmp_path / "half.nc")
    raw = {
        "time": "2024-04-20T22:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "view": {"zenith": 30.0},
        "image": {"rows": 4, "columns": 8},
        "frames": {"count": 1},
        "bands": NARROW,
        "sea": {"temperature": 291.0, "wind_speed": 5.0},
        "output": {"variables": ["radiance", "surface_class"], "certificate": 0},
        "accuracy": 1e-4,
        "surfaces": {"provider": "raster"},
    }
    parameters = {"file": "half.nc", "classes": {0: "sea", 1: "sand"}, "temperatures": {"sand": 307.0}}
    plan = make_plan(Scenario.from_dict(raw, {**CHEAP, "surfaces.parameters": parameters}, base=tmp_path))
    frame = next(stream(plan, tables_of(plan)))
    assert set(frame["surface_class"][0].tolist()) == {0, 1}
    grid, assembly, table = plan.spectral_grid, plan.assembly, Catalog().columns(
        Catalog().find("emissivity", "surfaces", ".csv"))  # fmt: skip
    wavenumber = grid.wavenumber_cm1
    through = assembly.transmittance.transmittance(wavenumber, [to_space(0.0, 30.0)])[0]
    sand = np.interp(1e4 / wavenumber, table["wavelength_um"], table["sand"]) * planck(wavenumber, 307.0)
    sea = assembly.sea.emissivity(wavenumber, np.cos(np.radians([30.0])))[0] * planck(wavenumber, 291.0)
    difference = grid.weights_cm1 @ (through * (sand - sea))
    seen = frame["radiance"].astype(float)
    np.testing.assert_allclose(seen[:, 0, -1] - seen[:, 0, 0], difference, atol=2e-4 * seen[:, 0, 0].max())


@pytest.mark.parametrize(("low", "high"), [(288.0, 292.0), (280.0, 300.0), (270.0, 305.0)])
def test_interpolation_in_temperature_is_exact_at_its_nodes_and_for_grey_bands(low, high, tmp_path):
    """The weights sum to 1, reproduce the black body of each band, and select single nodes at the nodes."""
    plan = make_plan(Scenario.load("stratus", {**CHEAP, "bands": NARROW}))
    grid = plan.spectral_grid
    axis, kelvin = temperature_axis(grid, low, high), np.linspace(low, high, 37)
    nodes = axis.within(low, high, quadrature.nodes(2))
    placed = PlacedAxis(axis, (nodes,))
    weights = placed.weights(0, kelvin)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0, rtol=1e-12)
    black = planck(grid.wavenumber_cm1, np.concatenate((nodes, kelvin))[:, None]) @ grid.weights_cm1.T
    found = np.einsum("nbt,nb->tb", weights, black[:3])
    np.testing.assert_allclose(found, black[3:], rtol=3e-5)
    np.testing.assert_allclose(placed.weights(0, nodes), np.tile(np.eye(3)[:, None], (1, 2, 1)), atol=1e-9)


class TestLambertian(SeaModelContract):
    reciprocity = 1e-12

    def make_provider(self, inputs):
        return material("rock", inputs.catalog)
