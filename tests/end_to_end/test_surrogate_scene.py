"""Surrogates of images in whole scenes: a made image through the engine, measured ones through the generator."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP
from PIL import Image
from sample_data import sample_file
from scipy.ndimage import gaussian_filter

from hcss_twin import Scenario, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.models.clouds.surrogate.generator import SurrogateClouds
from hcss_twin.models.clouds.surrogate.parameters import SurrogateParameters
from hcss_twin.models.clouds.surrogate.template import periodic_component
from hcss_twin.providers import CloudInputs, Grid, Motion
from hcss_twin.testing.samples import sample_layer


@pytest.fixture
def scenario(tmp_path):
    np.save(tmp_path / "image.npy", gaussian_filter(np.random.default_rng(0).normal(size=(80, 96)), 3.0))
    return {
        "time": "2024-04-20T12:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": 64, "columns": 80, "pixel_size": 200.0},
        "frames": {"count": 3, "interval": 60.0},
        "motion": {"wind_speed": 5.0, "evolution_time": 600.0},
        "bands": ["lwir-10.8"],
        "output": {"variables": ["radiance", "truth"]},
        "clouds": {
            "type": "stratus",
            "coverage": 0.3,
            "generator": "surrogate",
            "parameters": {"image": str(tmp_path / "image.npy"), "method": "coverage"},
        },
    }


def test_scene_has_the_coverage_asked_for_and_cold_clouds_that_change(scenario):
    cube = simulate(Scenario.from_dict(scenario, CHEAP))
    cloudy = cube.cloud_mask.values == 1
    assert np.all(cloudy.sum(axis=(1, 2)) == round(0.3 * 64 * 80))
    radiance = cube.radiance.sel(band="lwir-10.8").values
    assert radiance[cloudy].mean() < radiance[~cloudy].mean()
    kept = [np.mean(cloudy[0] & cloudy[n]) / 0.3 for n in (1, 2)]
    assert 1.0 > kept[0] > kept[1] > 0.3
    skipped = json.loads(cube.attrs["hcss_skipped"])
    assert any(item["what"] == "smooth component of the image" for item in skipped)


def test_scenario_that_asks_for_tapered_edges_is_told_where(scenario):
    scenario["clouds"]["edge_taper"] = 0.2
    with pytest.raises(ScenarioError, match=r"clouds\.edge_taper: 0\.2 given"):
        simulate(Scenario.from_dict(scenario, CHEAP))


def test_scenario_of_the_documentation_runs(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "how-to" / "clouds-from-images.md").read_text(encoding="utf-8")
    scenario = tomllib.loads(text.split("## Surrogates")[1].split("```toml\n")[1].split("```")[0])
    scenario["image"].update(rows=48, columns=64)
    scenario["frames"]["count"] = 1
    scenario["clouds"]["parameters"]["image"] = str(tmp_path / "clouds.png")
    grey = gaussian_filter(np.random.default_rng(1).normal(size=(100, 120)), 3.0)
    Image.fromarray((255 * (grey - grey.min()) / np.ptp(grey)).astype(np.uint8)).save(tmp_path / "clouds.png")
    cube = simulate(Scenario.from_dict(scenario, CHEAP))
    assert int(cube.cloud_mask.sum()) == round(0.3 * 48 * 64)


# --- measured images --------------------------------------------------------------------


def octave_power(field):
    ky, kx = (np.fft.fftfreq(size) * size for size in field.shape)
    wavenumber = np.hypot(ky[:, None], kx[None, :])
    power = np.abs(np.fft.fft2(field - field.mean())) ** 2
    edges = 2.0 ** np.arange(int(np.log2(min(field.shape))))
    return np.array([power[(wavenumber >= low) & (wavenumber < 2 * low)].sum() for low in edges]) / power.sum()


@pytest.mark.parametrize(
    ("pattern", "limit"),
    [
        ("*Cloud_Top_Height.nc", 0.3),
        ("Miriam*.jpg", 0.1),
        ("OR_ABI-L1b-RadC-M3C08_*.nc", 0.4),
        ("OR_ABI-L2-CMIPM2-M3C01_*.nc", 0.12),
        ("OR_ABI-L2-CMIPM2-M3C03_*.nc", 0.12),
    ],
)
def test_frames_have_the_amplitudes_and_the_spectrum_of_the_measured_image(pattern, limit):
    image = sample_file(f"images/{pattern}")
    size = min(300, *read_image(image).values.shape)
    for evolution_s in (3600.0, np.inf):
        inputs = CloudInputs(
            sample_layer(),
            Grid(size, size, 1000.0),
            Motion(0.0, (10.0, 0.0), evolution_s, 60.0),
            1,
            Catalog(base=image.parent),
        )
        clouds = SurrogateClouds(
            inputs, SurrogateParameters(image=image.name, missing="clear", reinterpret_pixel_size=True)
        )
        frame = clouds.thickness_m(90.0, slice(None), slice(None))
        template = clouds.template.thickness_m
        np.testing.assert_array_equal(np.sort(frame, axis=None), np.sort(template, axis=None))
        wanted = octave_power(periodic_component(template.astype(np.float64)))
        error = np.log(octave_power(frame.astype(np.float64)) / wanted)
        assert np.sqrt(np.mean(error**2)) < limit
        assert abs(np.corrcoef(frame.ravel(), template.ravel())[0, 1]) < 0.6
