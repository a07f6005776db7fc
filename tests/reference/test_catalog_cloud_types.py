"""Cloud types of the catalog have plausible infrared images, at the pixel sizes for which they are meant."""

import netCDF4
import numpy as np
import pytest

from hcss_twin import Scenario, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.clouds.fractal.expected_variogram import KernelCorrelation
from hcss_twin.models.clouds.fractal.parameters import FractalParameters
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.cloud_types import load_cloud_type

NAMES = Catalog().names("cloud_types", ".toml")
SEA = """
time = 2020-09-06T00:45:00+00:00
place = {latitude = 5.4, longitude = -27.7}
bands = ["lwir-10.8"]
frames.count = 1
accuracy = "0.1 K"
output.variables = ["brightness_temperature", "cloud_thickness"]
atmosphere.water_vapour_texture = 0.0
"""
MEASURED_CORRELATION = 0.9
"""Of neighbouring pixels of SEVIRI at 3 km: 0.91 in the least of 22 sea scenes, 0.96 on average."""


@pytest.mark.parametrize("name", NAMES)
def test_neighbouring_pixels_correlate_as_measured_up_to_the_pixel_size_of_the_type(name) -> None:
    cloud_type = load_cloud_type(name, Catalog())
    shape, kernel = FractalParameters(**cloud_type.fractal.model_dump(exclude_none=True)), KernelCorrelation.tabulate()

    def correlation(pixel_m):
        return 1.0 - float(np.max(kernel.expected_variogram(shape, pixel_m, [1, 0], [0, 1])))

    most = cloud_type.pixel_size_max
    assert correlation(most) >= MEASURED_CORRELATION
    assert correlation(1.1 * most) < MEASURED_CORRELATION


def test_the_plan_notes_pixels_that_are_too_large_for_a_fractal_type() -> None:
    values = {"image": {"rows": 8, "columns": 8, "pixel_size": 3000.0}, "clouds.type": "cumulus"}
    values |= {"output.variables": ["cloud_mask"]}  # the note does not depend on it, and no radiance is analysed

    def noted(**more):
        return any(
            "'cumulus' is meant for pixels of up to 70 m" in note
            for note in make_plan(
                Scenario.from_toml(SEA, values | {key.replace("__", "."): each for key, each in more.items()})
            ).notes
        )

    assert noted()
    assert not noted(image__pixel_size=70.0)
    assert not noted(clouds__parameters={"L": [1, 1]})


@pytest.mark.parametrize(
    ("name", "pixel_m", "coldest_K"),
    [
        ("deep-convection", 3000.0, (200.0, 217.0)),  # 15 km; tropopause of the tropical model atmosphere: 195 K
        ("altostratus", 500.0, (257.0, 266.0)),  # air at the top: 257 K; optical thickness up to 7
        ("altocumulus", 500.0, (272.0, 278.0)),
        ("fog", 300.0, (293.0, 296.0)),  # the sea is 300.5 K, and looks 4 to 6 K colder through the air
    ],
)
def test_types_beyond_the_papers_are_certified_and_as_cold_as_their_air(name, pixel_m, coldest_K, tmp_path) -> None:
    image = {"rows": 64, "columns": 64, "pixel_size": pixel_m}
    simulate(Scenario.from_toml(SEA, {"clouds.type": name, "image": image}), tmp_path / "cube.nc")
    with netCDF4.Dataset(tmp_path / "cube.nc") as cube:
        assert cube.hcss_certificate.startswith("computed as specified")
        kelvin = np.asarray(cube["brightness_temperature"][0, 0])
        cloudy = np.asarray(cube["cloud_thickness"][0]).reshape(kelvin.shape) > 0.0
    assert coldest_K[0] < kelvin.min() < coldest_K[1]
    assert kelvin[cloudy].max() <= kelvin[~cloudy].min() + 0.2
