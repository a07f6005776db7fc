"""Variables of providers: values, bits however a scene is divided, what is computed for them, and refusals."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from cheap import CHEAP
from installed_providers import install
from written_cubes import assert_same_bits

from hcss_twin import Scenario, make_plan, sense
from hcss_twin.core.errors import ScenarioError
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine import parts
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.simulate import run
from hcss_twin.engine.stages.derived import DerivedStage
from hcss_twin.engine.stages.truth import Truth
from hcss_twin.engine.stream import stream
from hcss_twin.engine.verification import Verdict, verify_cube
from hcss_twin.physics.geodesy import to_geographic
from hcss_twin.providers import Declaration, OutputVariable
from hcss_twin.providers.registry import ProviderSpec, hookimpl

TEMPLATE = "hcss_author.new_plugin.templates.variables"
SCENE = """
time = 2024-04-20T22:30:00+10:00
place = {latitude = 35.0, longitude = 150.0}
platform.altitude = "36000 km"
motion.platform_speed = 7000.0
view.zenith = 30.0
image = {rows = 30, columns = 40, samples_per_pixel = 2, pixel_size = 500.0}
frames.count = 2
bands = [{name = "mwir", limits = [3.6, 3.8]}, {name = "lwir", limits = [10.5, 11.0]}]
accuracy = 0.01
clouds = {type = "stratus", coverage = 0.5, coverage_mode = "field"}
output.variables = ["radiance", "cloud_mask", "temperature_difference", "difference_flag", "where"]

[[output.derived]]
provider = "split"
parameters.least = -3.0

[[output.derived]]
provider = "place"
"""


class Place:
    """Radiance, cloud and geometry of a pixel in one number."""

    declares = Declaration(notes=("a note",))
    needs = ("radiance_sea_emission", "cloud_optical_thickness", "latitude", "longitude", "view_zenith", "sun_zenith")
    variables = {  # noqa: RUF012
        "where": OutputVariable("1", "sum of everything", "Of no use.", per_band=True, dtype="float64"),
        "other": OutputVariable("1", "cloud", "Cloudy.", dtype="uint8", flag_meanings=("clear", "cloudy")),
    }

    def __init__(self, inputs, parameters):
        self.seen = {}

    def values(self, fields, time_s):
        self.seen = fields
        assert set(fields) == set(self.needs)
        assert not any(each.flags.writeable for each in fields.values())
        total = sum(fields[name].astype(float) for name in self.needs[:2])
        pixel = sum(fields[name] for name in self.needs[2:])
        return {"where": total + pixel, "other": fields["cloud_optical_thickness"][0] > 0.0}


class Clash(Place):
    variables = {"cloud_mask": OutputVariable("1", "x", "y")}  # noqa: RUF012


class Demanding(Place):
    needs = ("element_share",)
    variables = {"demand": OutputVariable("1", "x", "y")}  # noqa: RUF012


class Deep(Place):
    needs = ("cloud_thickness",)
    variables = {"depth": OutputVariable("km", "depth", "Thickness of the cloud.")}  # noqa: RUF012

    def values(self, fields, time_s):
        return {"depth": 1e-3 * fields["cloud_thickness"]}


class Plugin:
    @hookimpl
    def hcss_register_variables(self):
        classes = (Place, Clash, Demanding, Deep)
        specs = [
            ProviderSpec(each.__name__.lower(), f"{__name__}:{each.__name__}", None, 3, "a test") for each in classes
        ]
        return [ProviderSpec("split", f"{TEMPLATE}:Provider", f"{TEMPLATE}:Parameters", 3, "two bands"), *specs]


@pytest.fixture(scope="module", autouse=True)
def installed():
    with pytest.MonkeyPatch.context() as patch:
        install(patch, Plugin())
        yield


def planned(**changes):
    return make_plan(Scenario.from_toml(SCENE, {**CHEAP, **changes}))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("derived")


@pytest.fixture(scope="module")
def whole(folder):
    return run(planned(), folder / "whole.nc")


def test_values_are_those_of_the_inputs(folder, whole):
    every = ["radiance_sea_emission", "brightness_temperature", "cloud_optical_thickness", "geometry", "where"]
    given = {"output.variables": [*every, "temperature_difference", "other"], "output.certificate": 0}
    with open_cube(whole) as cube, open_cube(run(planned(**given), folder / "every.nc")) as more:
        kelvin = more["brightness_temperature"].to_numpy()
        np.testing.assert_array_equal(cube["temperature_difference"], kelvin[:, 0] - kelvin[:, 1])
        np.testing.assert_array_equal(cube["difference_flag"], kelvin[:, 0] - kelvin[:, 1] >= -3.0)
        sun = more["solar_zenith_angle"].to_numpy()[:, None, None]
        pixel = more["pixel_latitude"] + more["pixel_longitude"] + more["pixel_view_zenith"].astype(float)
        for name in every[:1]:
            values = more[name].to_numpy().astype(float) + more["cloud_optical_thickness"].to_numpy()
        expected = values + (pixel.to_numpy() + sun)[:, None]
        np.testing.assert_allclose(cube["where"], expected, rtol=1e-7)
        np.testing.assert_array_equal(more["other"], more["cloud_optical_thickness"][:, 0] > 0.0)
        assert cube["difference_flag"].attrs["flag_meanings"] == "small large"
        assert cube["where"].dtype == np.float64


def test_geometry_is_that_of_the_pixels_without_an_altitude_of_the_image_centre():
    plan = planned(**{"platform.altitude": None, "motion.platform_speed": 100.0})
    of_bands = np.full((2, 2, 3), 280.0, dtype=np.float32)
    frame = dict.fromkeys(("brightness_temperature", "radiance_sea_emission", "cloud_optical_thickness"), of_bands)
    DerivedStage(plan).values(frame, (slice(4, 6), slice(7, 10)), 3.0)
    (angles,) = (each.seen for each in plan.assembly.derived if "latitude" in each.needs)
    assert np.all(angles["view_zenith"] == 30.0)
    x = (np.arange(7, 10) - 19.5) * 500.0 + 300.0
    latitude, longitude = to_geographic(x, np.full(3, (4 - 14.5) * 500.0), 35.0, 150.0)
    np.testing.assert_allclose(angles["latitude"][0], latitude, rtol=1e-14)
    np.testing.assert_allclose(angles["longitude"][0], longitude, rtol=1e-14)


@pytest.fixture
def small_tiles():
    """Tiles of 400 pixels from the call on; patches of its own, on which no analysis of the scene depends."""

    def cut():
        patch.setattr(parts, "LARGEST_FRAME_BYTES", 1)
        patch.setattr(parts, "TILE_PIXELS", 400)

    with pytest.MonkeyPatch.context() as patch:
        yield cut


def test_windows_tiles_workers_and_zarr_have_the_same_bits(folder, whole, small_tiles):
    part = slice(11, 19), slice(17, 26)
    window = {"image.window": {"rows": [11, 19], "columns": [17, 26]}}
    assert_same_bits(whole, run(planned(**window), folder / "part.nc"), part)
    small_tiles()
    plan = planned()
    assert_same_bits(whole, run(plan, folder / "tiles.zarr"))
    with ThreadPoolExecutor(1) as executor:  # as in a worker, with a plan of its own
        made = list(parts.stream_parts(plan, tables_of(plan), executor=executor, workers=1))
    assert len(made) > 4
    with open_cube(whole) as cube:
        for part in made:
            for name, array in part.arrays.items():
                np.testing.assert_array_equal(array, cube[name].to_numpy()[part.frame][..., *part.place], name)


def test_verification_reproduces_them_and_names_their_provider(whole):
    assert verify_cube(whole).verdict is Verdict.IDENTICAL
    with open_cube(whole) as cube:
        providers = json.loads(cube.attrs["hcss_providers"])
        assert {"variables[0]", "variables[1]"} <= set(providers)
        assert providers["variables[1]"]["name"] == "place"
        assert cube["where"].attrs["hcss_inputs"] == " ".join(Place.needs)
        assert any("variable provider place: a note" in each for each in json.loads(cube.attrs["hcss_notes"]))


def test_rounding_comes_after_them(whole):
    rounded = planned(**{"output.quantization": 1e-4, "output.certificate": 0})
    frame = next(stream(rounded, tables_of(rounded)))
    with open_cube(whole) as cube:
        np.testing.assert_array_equal(frame["where"], cube["where"][0])  # float64 is not rounded
        difference = cube["temperature_difference"][0].to_numpy()
        np.testing.assert_allclose(frame["temperature_difference"], difference, rtol=1e-4)
        assert not np.array_equal(frame["radiance"], cube["radiance"][0])


def test_a_variable_of_truth_computes_no_radiance():
    plan = planned(**{"output.variables": ["depth"], "output.derived": [{"provider": "deep"}]})
    assert not plan.needs_radiance
    assert {spec.name for spec in plan.computed} == {"depth", "cloud_thickness"}


def test_a_sensor_cube_leaves_out_what_clean_radiance_gave(folder, whole):
    names = ["radiance", "other", "temperature_difference"]
    cube = run(planned(**{"output.variables": names, "output.certificate": 0}), folder / "clean.nc")
    with sense(cube, {"parameters": {"noise": "nedt", "nedt": 0.05}}) as measured:
        assert set(measured.data_vars) == {"radiance"}
    sense(cube, {"parameters": {"noise": "nedt", "nedt": 0.05}}, folder / "measured.nc").close()
    with open_cube(folder / "measured.nc") as measured:
        assert set(measured.data_vars) == {"radiance"}
    assert verify_cube(folder / "measured.nc").verdict is Verdict.IDENTICAL


@pytest.mark.parametrize(
    ("changes", "field", "message"),
    [
        ({"output.variables": ["radiance"]}, "output.derived[0]", "none of its variables is requested; allowed: "
         "output.variables with temperature_difference or difference_flag"),
        ({"output.variables": ["were"]}, "output.variables", "closest is 'where'"),
        ({"output.derived": [{"provider": "clash"}]}, "output.variables", "'cloud_mask' of a variable provider is a "
         "name of the engine"),
        ({"output.derived": [{"provider": "place"}] * 2}, "output.variables", "two variable providers give it"),
        ({"output.derived": [{"provider": "demanding"}], "output.variables": ["demand"]}, "output.derived[0].provider",
         "variable provider 'demanding' .* needs what the scene does not have: 'element_share': the scene has no el"),
        ({"output.derived": [{}]}, "output.derived[0].provider", "is missing"),
        ({"output.derived": [{"provider": "plaice"}]}, "output.derived[0].provider", "closest is 'place'"),
        ({"output.derived": [{"provider": "split", "least": 1.0}]}, "output.derived[0].least",
         r"output.derived\[0\].parameters.least"),
        ({"output.derived": [{"provider": "split", "parameters": {"leest": 1.0}}]},
         "output.derived[0].parameters.leest", "closest is 'least'"),
    ],
)  # fmt: skip
def test_wrong_requests_name_field_and_what_is_allowed(changes, field, message):
    with pytest.raises(ScenarioError, match=message) as error:
        planned(**changes)
    assert field in [each.field for each in error.value.problems]


def test_a_truth_variable_that_nothing_fills_is_refused(monkeypatch):
    plan = planned()
    [truth] = [spec for spec in plan.computed if spec.name == "cloud_mask"]
    with pytest.raises(ValueError, match="truth variable 'cloud_maks': the engine has no values for it"):
        Truth(replace(plan, computed=(replace(truth, name="cloud_maks"),)))
