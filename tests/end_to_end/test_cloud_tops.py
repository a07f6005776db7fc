"""Cloud tops of a generator: each pixel is that of a scene with its top, windows agree, and refusals are named."""

import warnings
from typing import ClassVar

import numpy as np
import pytest
from cheap import CHEAP, NARROW
from installed_providers import install

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.errors import ProviderError, ScenarioError
from hcss_twin.engine.simulate import run
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.providers import CloudDeclaration
from hcss_twin.providers.registry import ProviderSpec, hookimpl

SCENE = """
time = 2024-04-20T12:30:00+10:00
place = {latitude = 15.0, longitude = 150.0}
view.zenith = 30.0
image = {rows = 20, columns = 32, pixel_size = 1000.0}
frames.count = 1
bands = ["swir-2.7-3.0", "mwir", "lwir"]
accuracy = 0.005
atmosphere.profile = "tropical"
clouds = {type = "stratus", base = 1000.0, top = 2000.0, anchor = "top", thickness_min = 5.0, coverage_mode = "field", generator = "slope"}
output.variables = ["radiance", "cloud_top_altitude", "cloud_mask"]
"""  # noqa: E501
RANGE = 400.0, 9000.0
COAST = {"latitude": 35.15, "longitude": 139.6}


class Level:
    """Cloud whose thickness grows from row to row by a factor; the first four rows are clear."""

    declares = CloudDeclaration()
    image_coverage = 0.8
    expected_failures: ClassVar = {"frozen_field_only_translates": "the cloud stands still in the image"}

    def __init__(self, inputs, parameters):
        self.last = inputs.grid.columns - 1

    def thickness_m(self, time_s, rows, columns):
        row = np.arange(rows.start, rows.stop, dtype=np.float32)[:, None]
        thickness = np.where(row < 4, 0.0, np.minimum(6.0 * 1.3**row, 900.0))
        return np.broadcast_to(thickness, (row.size, columns.stop - columns.start)).astype(np.float32)


class Slope(Level):
    """The same cloud, whose top rises along the columns; never thicker than it is high."""

    cloud_top_range_m = RANGE

    def cloud_top_m(self, time_s, rows, columns):
        share = np.arange(columns.start, columns.stop) / self.last
        top = RANGE[0] + (RANGE[1] - RANGE[0]) * np.broadcast_to(share, (rows.stop - rows.start, share.size))
        return top.astype(np.float32)

    def thickness_m(self, time_s, rows, columns):
        return np.minimum(super().thickness_m(time_s, rows, columns), self.cloud_top_m(time_s, rows, columns))


class Wrong(Slope):
    cloud_top_range_m = 400.0, 5000.0


class High(Slope):
    cloud_top_range_m = 10_200.0, 11_000.0

    def cloud_top_m(self, time_s, rows, columns):
        top = np.linspace(*self.cloud_top_range_m, self.last + 1)[columns.start : columns.stop]
        return np.broadcast_to(top, (rows.stop - rows.start, top.size)).astype(np.float32)


class Plugin:
    @hookimpl
    def hcss_register_cloud_generators(self):
        return [
            ProviderSpec(each.__name__.lower(), f"{__name__}:{each.__name__}", None, 3, "a test")
            for each in (Level, Slope, Wrong, High)
        ]


@pytest.fixture(scope="module", autouse=True)
def installed():
    with pytest.MonkeyPatch.context() as patch:
        install(patch, Plugin())
        yield


def scene(**changes):
    return Scenario.from_toml(SCENE, {**CHEAP, **changes})


@pytest.mark.parametrize(
    ("changes", "columns"),
    [
        ({}, (3, 17, 31)),
        ({"platform.altitude": 500e3, "bands": NARROW[:1]}, (31,)),
        ({"sea.temperature_texture": 0.5, "atmosphere.water_vapour_texture": 0.05, "bands": NARROW[1:]}, (17,)),
        ({"surfaces": {"provider": "coast"}, "place": COAST, "bands": NARROW[1:]}, (17,)),
    ],
    ids=["one view", "views over the image", "texture", "a coast"],
)
def test_a_pixel_is_that_of_a_scene_with_its_cloud_top(changes, columns):
    whole = simulate(scene(**changes))
    assert whole.attrs["hcss_certificate"].startswith("computed as specified")
    tops = whole["cloud_top_altitude"].to_numpy()[0]
    assert np.isnan(tops[:4]).all()
    np.testing.assert_allclose(tops[4:, 0], RANGE[0])
    for column in columns:
        top = float(np.float32(RANGE[0] + (RANGE[1] - RANGE[0]) * column / 31.0))
        np.testing.assert_allclose(tops[4:, column], top)
        own = {"clouds.generator": "level", "clouds.top": top, "clouds.base": max(top - 1000.0, 0.0)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the lowest layer is thinner than some clouds
            alone = simulate(scene(**changes, **own, **{"output.certificate": 0}))
        np.testing.assert_allclose(whole["radiance"][0, ..., column], alone["radiance"][0, ..., column], rtol=2 * 0.005)


@pytest.mark.parametrize("area", [1e3, 4e6], ids=["small", "larger than a pixel"])
def test_an_element_has_the_cloud_of_its_own_column_before_it(area):
    """Its height within the cloud decides how much of that weakens it: as in a scene with the top of its column."""
    column, row = 17, 16
    top = float(np.float32(RANGE[0] + (RANGE[1] - RANGE[0]) * column / 31.0))
    place = {"x": (column - 15.5) * 1000.0, "y": (row - 9.5) * 1000.0}
    track = place | {"altitude": top - 60.0, "temperature": 900.0, "area": area}
    source = {"provider": "point-sources", "parameters": {"tracks": [track]}}
    wanted = {"output.variables": ["radiance", "element_radiance", "element_transmittance"], "elements": [source]}
    whole = simulate(scene(**wanted))
    assert whole.attrs["hcss_certificate"].startswith("computed as specified")
    own = {"clouds.generator": "level", "clouds.top": top, "clouds.base": top - 1000.0, "output.certificate": 0}
    alone = simulate(scene(**wanted, **own))
    for name in ("element_radiance", "element_transmittance"):
        found, expected = (made[name].values[0][:, row, column] for made in (whole, alone))
        np.testing.assert_allclose(found, expected, rtol=1e-3, err_msg=name)
    below = {"elements": [source | {"parameters": {"tracks": [track | {"altitude": 100.0}]}}]}
    hidden = simulate(scene(**wanted | below | {"output.certificate": 0}))
    assert np.all(hidden["element_transmittance"].values[0][:, row, column] < 0.5 * expected)


LOW = {"type": "stratus", "base": 1000.0, "top": 2000.0, "anchor": "top", "thickness_min": 5.0, "generator": "slope"}
CIRRUS = {"type": "cirrus", "base": 10e3, "top": 11e3, "coverage": 0.5}


@pytest.mark.parametrize(
    "high", [CIRRUS, CIRRUS | {"generator": "high", "thickness_min": 5.0}], ids=["fixed", "varying"]
)
def test_tops_vary_below_another_layer_and_in_both(high):
    layers = [layer | {"coverage_mode": "field"} for layer in (LOW, high)]
    made = simulate(scene(**{"clouds": {"layers": layers}, "bands": NARROW[1:], "output.certificate": 12}))
    assert made.attrs["hcss_certificate"].startswith("computed as specified")
    tops = made["cloud_top_altitude"].to_numpy()[0]
    share = np.arange(32) / 31.0
    below = RANGE[0] + (RANGE[1] - RANGE[0]) * share
    covered = tops > RANGE[1]
    assert np.count_nonzero(covered) > 0
    np.testing.assert_allclose(np.where(covered, below, tops)[4:], np.tile(below, (16, 1)), rtol=1e-6)
    if "generator" in high:
        np.testing.assert_allclose(tops[4:], np.tile(10_200.0 + 800.0 * share, (16, 1)), rtol=1e-6)


def test_a_layer_that_tops_may_reach_is_refused():
    layers = [layer | {"coverage_mode": "field"} for layer in (LOW, CIRRUS | {"base": 8000.0})]
    with pytest.raises(ProviderError, match=r"400 to 9000 m; allowed: .* up to 8000 m, which the layers"):
        make_plan(scene(**{"clouds": {"layers": layers}}))


def test_a_sweep_is_resumed_only_with_the_code_of_its_plugins():
    plugin_code = pytest.importorskip("hcss_sweep.points").plugin_code
    before = plugin_code([scene(), scene(**{"clouds.generator": "level"})])
    assert set(before) == {"hcss-test/slope", "hcss-test/level"}
    assert plugin_code([scene(**{"clouds.generator": "fractal"})]) == {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hcss_twin.core.result_cache.code_fingerprint", lambda *_: "another")
        assert plugin_code([scene()])["hcss-test/slope"] != before["hcss-test/slope"]


def test_windows_agree_with_the_image_and_the_file_is_verified(tmp_path):
    few = {"bands": NARROW[1:], "output.certificate": 0}
    whole = simulate(scene(**few))
    window = {"rows": [3, 17], "columns": [5, 30]}
    part = simulate(scene(**few, **{"image.window": window}))
    for name in ("radiance", "cloud_top_altitude"):
        np.testing.assert_array_equal(part[name], whole[name][..., 3:17, 5:30], err_msg=name)
    path = run(make_plan(scene(**few | {"image.samples_per_pixel": 2})), tmp_path / "cube.nc")
    assert verify_cube(path).verdict is Verdict.IDENTICAL


@pytest.mark.parametrize(("changes", "field"), [({"clouds.temperature": 270.0}, "clouds.temperature")])
def test_what_cannot_be_combined_is_refused_by_name(changes, field):
    with pytest.raises(ScenarioError, match="cloud tops that vary") as error:
        make_plan(scene(**changes))
    assert field in [each.field for each in error.value.problems]


def test_a_top_outside_the_declared_range_is_the_fault_of_the_generator():
    with pytest.raises(ProviderError, match=r"cloud_top_m\(\) broke its contract: .*5000"):
        simulate(scene(**{"clouds.generator": "wrong"}))
