"""Surrogates of images in whole scenes: a made image through the engine, measured ones through the generator."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from conftest import octave_power
from hcss_author import sample_cloud_inputs
from hcss_skies.surrogate.generator import SurrogateClouds
from hcss_skies.surrogate.parameters import SurrogateParameters
from hcss_skies.surrogate.template import periodic_component
from PIL import Image
from scipy.ndimage import gaussian_filter

from hcss_twin import Scenario, make_plan, simulate
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ScenarioError
from hcss_twin.laws.samples import sample_layer
from hcss_twin.models.clouds.imagery.reader import read_image
from hcss_twin.providers import CloudInputs, Grid, Motion

CHEAP = {
    "radiance.model": "as-printed",
    "sea.model": "cox-munk",
    "optics.provider": "mie",
    "slant.shadows": "off",
    "slant.parallax": "off",
}


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
    text = (Path(__file__).parents[3] / "docs" / "how-to" / "clouds-from-images.md").read_text(encoding="utf-8")
    scenario = tomllib.loads(text.split("## Surrogates")[1].split("```toml\n")[1].split("```")[0])
    scenario["image"].update(rows=48, columns=64)
    scenario["frames"]["count"] = 1
    scenario["clouds"]["parameters"]["image"] = str(tmp_path / "clouds.png")
    grey = gaussian_filter(np.random.default_rng(1).normal(size=(100, 120)), 3.0)
    Image.fromarray((255 * (grey - grey.min()) / np.ptp(grey)).astype(np.uint8)).save(tmp_path / "clouds.png")
    cube = simulate(Scenario.from_dict(scenario, CHEAP))
    assert int(cube.cloud_mask.sum()) == round(0.3 * 48 * 64)


def test_surrogate_has_the_histogram_of_its_image_in_kelvin(tmp_path):
    scene = {
        "time": "2024-04-20T22:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": 48, "columns": 48, "pixel_size": 1000.0},
        "frames": {"count": 1},
        "bands": ["lwir-10.8"],
        "output": {"variables": ["brightness_temperature"], "certificate": 0},
        "atmosphere": {"profile": "us-standard-1976"},
        "clouds": {"type": "paper-stratus", "thickness_min": 1.0, "generator": "fractal"},
    }
    inversion = make_plan(Scenario.from_dict(scene, CHEAP)).assembly.built["clouds"].inputs.inversion
    field = gaussian_filter(np.random.default_rng(3).normal(size=(48, 48)), 3.0, mode="wrap")
    coldest = inversion.coldest_K + 0.5
    kelvin = coldest + (inversion.clear_K - coldest) * (field - field.min()) / np.ptp(field)
    image = xr.Dataset({"brightness_temperature": xr.DataArray(kelvin, dims=("y", "x"), attrs={"units": "K"})})
    image.to_netcdf(tmp_path / "image.nc")
    parameters = {"image": str(tmp_path / "image.nc"), "method": "temperature"}
    scene["clouds"] |= {"generator": "surrogate", "parameters": parameters}
    seen = simulate(Scenario.from_dict(scene, CHEAP)).brightness_temperature.values
    np.testing.assert_allclose(np.sort(seen, axis=None), np.sort(kelvin, axis=None), atol=0.15)


def test_no_netcdf_file_is_opened_while_frames_are_computed(tmp_path, monkeypatch):
    """The engine computes them while another thread writes one."""
    image = xr.DataArray(np.random.default_rng(0).random((80, 96)), dims=("y", "x"))
    xr.Dataset({"data": image}).to_netcdf(tmp_path / "image.nc")
    inputs = sample_cloud_inputs(catalog=Catalog(base=tmp_path))
    clouds = SurrogateClouds(inputs, SurrogateParameters(image="image.nc", method="coverage"))
    monkeypatch.setattr(netCDF4, "Dataset", None)
    assert clouds.thickness_m(90.0, slice(None), slice(None)).any()


def test_results_are_those_recorded():
    record = Path(__file__).parents[3] / "tests" / "bits" / "record.py"
    done = subprocess.run([sys.executable, record, "surrogate-clouds"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


# --- measured images --------------------------------------------------------------------


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
    images = sorted((Path(os.environ.get("HCSS_SAMPLE_DATA", "")) / "images").glob(pattern))
    if not images:
        pytest.skip(f"HCSS_SAMPLE_DATA names no folder with images/{pattern}")
    image = images[0]
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
