"""Shipped cloud types take the sky that is believable at the scene's pixel size."""

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.engine.verification import verify_cube
from hcss_twin.scenario.cloud_types import load_cloud_type


def scene(of_type, pixel_m=20.0, size=48, model="as-printed", variables=("radiance", "truth"), **clouds):
    return Scenario.from_dict(
        {
            "time": "2024-04-20T12:30:00Z",
            "place": {"latitude": 25.0, "longitude": -45.0},
            "image": {"rows": size, "columns": size, "pixel_size": pixel_m},
            "frames": {"count": 2, "interval": 30.0},
            "accuracy": 0.01,
            "bands": ["lwir-10.8"],
            "radiance": {"model": model},
            "sea": {"model": "cox-munk"},
            "optics": {"provider": "mie"},
            "output": {"variables": list(variables)},
            "clouds": {"type": of_type, **clouds},
        }
    )


@pytest.mark.parametrize(
    ("of_type", "pixel_m", "generator", "coverage"),
    [
        ("cumulus", 20.0, "hcss-skies/simulation", 0.15),
        ("cumulus", 300.0, "hcss-skies/simulation", 0.15),
        ("cumulus", 3000.0, "hcss-skies/example", 0.44),
        ("stratocumulus", 50.0, "hcss-skies/simulation", 0.8),
        ("stratocumulus", 1000.0, "hcss-skies/simulation", 0.8),
        ("stratocumulus", 3000.0, "hcss-skies/example", 0.83),
        ("stratus", 20.0, "hcss-skies/simulation", 0.99),
        ("stratus", 500.0, "hcss-skies/simulation", 0.99),
        ("stratus", 3000.0, "hcss-skies/simulation", 0.99),
        ("cirrus", 20.0, "hcss-skies/fall-streaks", 0.5),
        ("cirrus", 1000.0, "hcss-skies/fall-streaks", 0.5),
        ("deep-convection", 3000.0, "hcss-skies/example", 0.9),
        ("altocumulus", 50.0, "hcss-skies/simulation", 0.8),
        ("altocumulus", 300.0, "fractal", 0.5),
        ("thick-fog", 50.0, "hcss-skies/simulation", 1.0),
        ("thick-fog", 300.0, "fractal", 0.5),
        ("fog", 50.0, "fractal", 0.5),
        ("paper-cumulus", 20.0, "fractal", 0.5),
    ],
)
def test_type_takes_the_sky_of_the_pixel_size(of_type, pixel_m, generator, coverage):
    (layer,) = scene(of_type, pixel_m).clouds.layers
    assert (layer.generator, layer.coverage) == (generator, coverage)


@pytest.mark.parametrize(("of_type", "pixel_m"), [("stratocumulus", 3000.0), ("cumulus", 3000.0), ("cumulus", 300.0)])
def test_clear_sky_between_clouds_of_examples_and_films_has_texture(of_type, pixel_m):
    assert make_plan(scene(of_type, pixel_m)).texture.temperature_K == 0.3


@pytest.mark.parametrize("of_type", ["stratocumulus", "cumulus"])
def test_tops_of_examples_are_not_flat(of_type):
    """Before, a tenth of the deck of stratocumulus had one temperature."""
    (clouds,) = make_plan(scene(of_type, 3000.0, size=192, model="physical")).assembly.generators
    thickness = clouds.thickness_m(0.0, slice(0, 192), slice(0, 192))
    cloudy = thickness[thickness > 0.0]
    assert np.mean(cloudy > 0.999 * cloudy.max()) < 0.03


def test_stated_generator_and_coverage_stay():
    assert scene("cumulus", generator="fractal").clouds.layers[0].generator == "fractal"
    assert scene("cumulus", coverage=0.3).clouds.layers[0].coverage == 0.3


def test_cube_of_a_shipped_film_is_verified_without_naming_the_film(tmp_path):
    cube = tmp_path / "cube.nc"
    simulate(scene("cumulus", 50.0), cube)
    found = verify_cube(cube)
    assert found.problems == ()
    assert found.passed


@pytest.mark.long
@pytest.mark.parametrize("of_type", ["cumulus", "stratocumulus", "stratus", "cirrus", "deep-convection"])
def test_skies_keep_the_laws_at_the_limits_of_their_pixel_sizes(of_type):
    """The plan holds generators to the laws, that of the coverage included."""
    for sky in load_cloud_type(of_type, Catalog()).sky:
        for pixel_m in {sky.pixel_size_min, min(sky.pixel_size_max, 6000.0)}:
            plan = make_plan(scene(of_type, pixel_m, size=96))
            assert plan.assembly.generators


@pytest.mark.parametrize("of_type", ["cumulus", "stratocumulus", "deep-convection"])
def test_examples_of_types_have_the_cover_that_the_catalog_states(of_type):
    """Under the place's inversion, too, above which the air is warmer than the deck."""
    described = scene(of_type, 4000.0, size=128, model="physical", variables=["cloud_mask"])
    (layer,) = described.clouds.layers
    found = simulate(described)
    assert float(found.cloud_mask.mean()) == pytest.approx(layer.coverage, abs=0.1)
