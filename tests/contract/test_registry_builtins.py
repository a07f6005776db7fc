"""Every built-in provider is held to the kit that plugin authors use, made through the registry."""

from dataclasses import replace
from functools import cache
from typing import ClassVar

import numpy as np
import pytest
from hcss_author import (
    CloudGeneratorContract,
    ElementContract,
    OpticsContract,
    PlainGas,
    RadianceModelContract,
    SeaModelContract,
    SensorContract,
    SurfaceContract,
    TransmittanceContract,
    assert_registered,
    sample_atmosphere_inputs,
    sample_cloud_inputs,
    sample_microphysics,
    sample_radiance_inputs,
    sample_sea_inputs,
    sample_sensor_inputs,
    sample_wavenumbers,
)
from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.database.segmentation import Cleaning
from surface_files import write_netcdf

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.physics.profile import airmass_of_legs
from hcss_twin.providers import Motion
from hcss_twin.providers.registry import Kind, Registry
from hcss_twin.providers.registry.guard import guard

HELD_TO_THE_KIT = {
    "clouds": {"fractal", "imagery"},
    "sea": {"cox-munk", "rough-sea"},
    "optics": {"bulk", "mie"},
    "atmosphere": {"band-model", "table"},
    "radiance": {"as-printed", "physical", "physical-two-stream"},
    "elements": {"point-sources"},
    "surfaces": {"coast", "raster"},
    "variables": set(),
    "sensors": {"radiometer"},
}


discovered = cache(Registry.discover)


def create(kind, name, inputs, **parameters):
    """A built-in provider behind its guard, as the engine uses it."""
    registry = discovered()
    entry = registry.resolve(kind, f"hcss-twin/{name}")
    provider = registry.create(entry, inputs, registry.parameters_model(entry)(**parameters))
    return guard(entry, provider, inputs)


class FewWavenumbers:
    """Fewer than the kit's twelve: the time of most tests is in proportion to them."""

    count = 4

    @pytest.fixture
    def wavenumber_cm1(self, provider):
        return sample_wavenumbers(provider.declares, self.count)


def test_no_builtin_escapes_the_kit():
    builtin = [entry for entry in Registry.discover().entries() if entry.distribution == "hcss-twin"]
    found = {str(kind): {entry.name for entry in builtin if entry.kind is kind} for kind in Kind}
    assert found == HELD_TO_THE_KIT


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind, names in HELD_TO_THE_KIT.items() for name in sorted(names)]
)
def test_builtin_is_soundly_registered(kind, name):
    assert_registered(kind, name, "hcss-twin")


class TestPointSources(ElementContract):
    def make_provider(self, inputs):
        moving = {"x": -900.0, "y": 130.0, "altitude": 9e3, "velocity": [250.0, 40.0, 0.0], "intensity": 1e3}
        warm = {"temperature": 600.0, "area": 4.0, "y": -4700.0}
        return create("elements", "point-sources", inputs, tracks=[moving, warm], footprint=500.0)


class TestCoast(SurfaceContract):
    def make_provider(self, inputs):
        def ground(*window):  # the sample is over the open sea
            latitude, longitude = inputs.ground(*window)
            return latitude + 0.65, longitude - 10.15

        return create("surfaces", "coast", replace(inputs, ground=ground), land="forest", land_temperature=295.0)


class TestRaster(SurfaceContract):
    @pytest.fixture(autouse=True)
    def file(self, tmp_path):
        latitude, longitude = np.linspace(34.0, 36.0, 101), np.linspace(149.0, 151.0, 91)
        kelvin = 270.0 + 40.0 * np.add.outer(latitude - 34.0, longitude - 149.0) / 4.0
        write_netcdf(tmp_path / "map.nc", latitude, longitude, surface_class=kelvin // 4.0, skin=kelvin)
        self._file = str(tmp_path / "map.nc")

    def make_provider(self, inputs):
        classes = {number: "sea" if number % 2 else "snow" for number in range(60, 80)}
        return create("surfaces", "raster", inputs, file=self._file, classes=classes, temperature_layer="skin")


class TestFractal(CloudGeneratorContract):
    coverage_tolerance = 1e-3  # exact in each frame, to a pixel

    def make_provider(self, inputs):
        return create("clouds", "fractal", inputs, gamma=2.0, H=0.6, L=[2.0, 3.0], k=[0, 5])


class TestFractalOneSky(TestFractal):
    coverage_tolerance = 0.05  # exact in the mean over the unbounded sky

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = super().make_inputs(coverage, seed)
        return replace(inputs, layer=replace(inputs.layer, coverage_mode="field"))

    def make_provider(self, inputs):
        return create("clouds", "fractal", inputs, gamma=2.0, H=0.6, L=[80.0, 90.0], k=[0, 5])


class TestImagery(CloudGeneratorContract):
    coverage_tolerance = 1e-3
    seeds = 2  # which it does not use

    @pytest.fixture(autouse=True)
    def _image(self, tmp_path):
        self.folder = tmp_path
        np.save(tmp_path / "image.npy", np.random.default_rng(5).random((128, 160)))

    def make_inputs(self, coverage=0.5, seed=1):
        slow = Motion(0.5, (0.1, -0.1), 1800.0, 2.0)
        return sample_cloud_inputs(coverage, seed, catalog=Catalog(base=self.folder), motion=slow)

    def make_provider(self, inputs):
        return create("clouds", "imagery", inputs, image="image.npy", method="coverage", reinterpret_pixel_size=True)


class TestScatteredClouds(CloudGeneratorContract):
    coverage_tolerance = 0.02

    def make_inputs(self, coverage=0.5, seed=1):
        return sample_cloud_inputs(coverage, seed, catalog=Catalog(base=self.folder))

    @pytest.fixture(autouse=True)
    def _entry(self, tmp_path):
        self.folder = tmp_path
        image = np.zeros((128, 160))
        for number in range(12):
            top, left = 5 + 40 * (number // 4), 5 + 38 * (number % 4)
            image[top : top + 3 + number % 5, left : left + 2 + number % 7] = 0.5 + 0.04 * number
        np.save(tmp_path / "image.npy", image)
        (tmp_path / "clouds").mkdir()
        entry = import_image(tmp_path / "image.npy", ImportOptions(pixel_size_m=200.0, cleaning=Cleaning(1)))
        entry.write(tmp_path / "clouds" / "squares.nc")

    def make_provider(self, inputs):
        return create("clouds", "imagery", inputs, entry="squares", placement="single-clouds")


class TestScatteredCloudsOfAField(TestScatteredClouds):
    def make_inputs(self, coverage=0.5, seed=1):
        inputs = super().make_inputs(coverage, seed)
        return replace(inputs, layer=replace(inputs.layer, coverage_mode="field"))


def at_winds(*speeds_m_s):
    @pytest.fixture(params=speeds_m_s, ids="wind {:g} m/s".format)
    def inputs(self, request):
        return sample_sea_inputs(wind_speed_m_s=request.param)

    return inputs


class TestCoxMunk(FewWavenumbers, SeaModelContract):
    inputs = at_winds(2.0, 10.0, 20.0)

    def make_provider(self, inputs):
        return create("sea", "cox-munk", inputs)


class TestRoughSea(TestCoxMunk):
    reciprocity = 1e-6
    parameters: ClassVar[dict[str, str]] = {}

    def make_provider(self, inputs):
        return create("sea", "rough-sea", inputs, **self.parameters)


class TestRoughSeaAlongTheWind(TestRoughSea):
    inputs = at_winds(10.0)
    parameters: ClassVar[dict[str, str]] = {"slopes": "upwind-crosswind", "spectrum": "jonswap"}


class TestRoughSeaSkewed(TestRoughSea):
    inputs = at_winds(2.0, 20.0)  # its density is least sure far from the usual wind
    parameters: ClassVar[dict[str, str]] = {"slopes": "gram-charlier", "shadowing": "separable"}


class TestMie(FewWavenumbers, OpticsContract):
    count = 5

    @pytest.fixture(params=["water", "ice"])
    def cloud(self, request):
        # Ice of half the kit's size, and both up to five times the mode radius: large spheres have many terms.
        if request.param == "water":
            return replace(sample_microphysics("water"), radius_range_um=(0.08, 20.0))
        return replace(sample_microphysics("ice"), b=0.6, radius_range_um=(0.2, 50.0))

    def make_provider(self, inputs):
        return create("optics", "mie", inputs)


class TestMieWithHenyeyGreenstein(TestMie):
    def make_provider(self, inputs):
        return create("optics", "mie", inputs, phase_function="henyey-greenstein")


class TestBulk(TestMie):
    def make_provider(self, inputs):
        return create("optics", "bulk", inputs)


class TestTable(TransmittanceContract):
    @pytest.fixture
    def inputs(self):
        return sample_atmosphere_inputs(load_profile("us-standard-1976", Catalog()))

    def make_provider(self, inputs):
        return create("atmosphere", "table", inputs)


class TestBandModel(TransmittanceContract):
    @pytest.fixture(params=["none", "maritime"])
    def aerosol(self, request):
        return request.param

    @pytest.fixture
    def inputs(self):
        return sample_atmosphere_inputs(load_profile("us-standard-1976", Catalog()))

    @pytest.fixture
    def provider(self, inputs, aerosol):
        return create("atmosphere", "band-model", inputs, aerosol=aerosol)

    def make_provider(self, inputs):
        return create("atmosphere", "band-model", inputs)


class TestAsPrinted(FewWavenumbers, RadianceModelContract):
    count = 5
    expected_failures = AsPrinted.expected_failures

    def make_provider(self, inputs):
        return create("radiance", "as-printed", inputs)


FEW_STREAMS = {"streams": 4, "sun_streams": 4, "azimuth_modes": 8}


class LegsTogether(PlainGas):
    """The kit's grey gas, faster where a model asks for hundreds of paths: all their legs are computed at once."""

    def transmittance(self, wavenumber_cm1, paths):
        legs = airmass_of_legs(self._profile, [leg for path in paths for leg in path.legs]) @ self._weights
        path_of_leg = np.repeat(np.arange(len(paths)), [len(path.legs) for path in paths])
        mass = np.bincount(path_of_leg, legs, len(paths))
        return np.repeat(np.exp(-self._vertical_depth * mass)[:, None], wavenumber_cm1.size, axis=1)


class PhysicalContract(FewWavenumbers, RadianceModelContract):
    count = 5

    @pytest.fixture
    def inputs(self):
        inputs = sample_radiance_inputs()
        setting = replace(inputs.setting, transmittance=LegsTogether(inputs.setting.profile))
        return replace(inputs, setting=setting)


class TestPhysical(PhysicalContract):
    def make_provider(self, inputs):
        return create("radiance", "physical", inputs)


class TestPhysicalTwoStream(PhysicalContract):
    def make_provider(self, inputs):
        return create("radiance", "physical-two-stream", inputs, **FEW_STREAMS)


class TestRadiometer(SensorContract):
    parameters: ClassVar[dict[str, object]] = {}

    def make_provider(self, inputs):
        return create("sensors", "radiometer", inputs, **self.parameters)


class TestRadiometerThatCounts(TestRadiometer):
    parameters: ClassVar[dict[str, object]] = {
        "psf": "airy",
        "aperture_diameter": 0.2,
        "pixel_angle": 3e-5,
        "integration_time": 0.01,
        "noise": "photon",
        "read_noise": 50.0,
        "dark_current": 1e4,
        "gain_deviation": 0.01,
        "offset_electrons": 20.0,
        "well_depth": 3e7,
        "bits": 14,
        "number_offset": 50,
    }


class TestRadiometerThatCountsWithoutOptics(TestRadiometer):
    parameters: ClassVar[dict[str, object]] = {
        "aperture_diameter": 0.01,
        "pixel_angle": 3e-5,
        "integration_time": 1e-6,
        "smear": False,
        "noise": "photon",
    }


class TestRadiometerWithNoiseOfASize(TestRadiometer):
    parameters: ClassVar[dict[str, object]] = {
        "noise": "nedt",
        "nedt": {"mid": 0.1, "long": 0.05},
        "fixed_pattern": "row",
        "offset_radiance": 0.01,
        "saturation_radiance": {"mid": 4.0, "long": 90.0},
        "bits": 12,
    }


class TestRadiometerWithAKernel(TestRadiometer):
    @pytest.fixture(autouse=True)
    def _kernel(self, tmp_path):
        self.folder = tmp_path
        (tmp_path / "kernel.txt").write_text("0 1 0\n1 4 2\n0 1 0\n", encoding="utf-8")

    @pytest.fixture
    def inputs(self):
        return sample_sensor_inputs(catalog=Catalog(base=self.folder))

    def make_provider(self, inputs):
        return create("sensors", "radiometer", inputs, psf="file", psf_file="kernel.txt")
