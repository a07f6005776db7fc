"""A scene of a measured image has the image's coverage and grey levels, by an independent reading of the file."""

import json
from pathlib import Path

import numpy as np
import pytest
from cheap import CHEAP
from click.testing import CliRunner
from hcss_evaluate.database.samples import samples
from netCDF4 import Dataset
from PIL import Image
from scipy.stats import spearmanr

from hcss_twin import Scenario, simulate
from hcss_twin.cli.main import cli
from hcss_twin.core.catalog import Catalog

SAMPLES = samples(Catalog())
THICKNESS_MIN = 100.0


def measured(name):
    """Levels of the sample's part of the file, larger where cloudier, row 0 in the north."""
    sample = SAMPLES[name]
    pytest.importorskip(sample.package.replace("-", "_"))
    path = sample.path()
    if path.suffix == ".nc":
        with Dataset(path) as file:
            level = -np.asarray(file.variables["data"][...], dtype=float)
    else:
        with Image.open(path) as picture:
            red, green, blue = np.moveaxis(np.asarray(picture, dtype=float), 2, 0)
        level = (299 * red + 587 * green + 114 * blue) / 1000
    row, column, rows, columns = sample.crop
    return level[row : row + rows, column : column + columns]


def least_spread(level):
    """Otsu's threshold as the split of 256 equal steps with the least variance within its two classes."""
    edges = np.linspace(level.min(), level.max(), 257)[1:-1]
    parts = [(level[level <= edge], level[level > edge]) for edge in edges]
    return edges[np.argmin([below.size * below.var() + above.size * above.var() for below, above in parts])]


def imported(name, *options):
    done = CliRunner().invoke(cli, ["clouds", "import", "--sample", name, "--json", *options], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.output)


def scene(name):
    answer = imported(name)
    rows, columns = SAMPLES[name].crop[2:]
    scenario = {
        "time": "2024-04-20T12:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": rows, "columns": columns, "pixel_size": answer["pixel_size_m"]},
        "frames": {"count": 1},
        "motion": {"platform_speed": 0.0, "wind_speed": 0.0},
        "bands": ["lwir-10.8"],
        "output": {"variables": ["radiance", "cloud_mask", "cloud_thickness"]},
        "clouds": {"type": "cumulus", "thickness_min": THICKNESS_MIN, "generator": "imagery"},
    }
    scenario["clouds"]["parameters"] = {"entry": str(Path(answer["entry"]).resolve())}
    return answer, simulate(Scenario.from_dict(scenario, CHEAP))


@pytest.mark.parametrize("name", SAMPLES)
def test_coverage_and_grey_levels_of_a_measured_image_come_back(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    level = measured(name)
    answer, cube = scene(name)
    threshold = least_spread(level)
    cloudy = level > threshold
    mask, thickness = (cube[name][0, ::-1].values for name in ("cloud_mask", "cloud_thickness"))
    radiance = cube.radiance[0, 0, ::-1].values
    assert answer["licence"] == SAMPLES[name].licence
    assert abs(mask.mean() - cloudy.mean()) < 0.01
    both = cloudy & (mask == 1)
    top = np.percentile(level[cloudy], 99.9)
    grey = np.rint(1 + 254 * np.clip((level - threshold) / (top - threshold), 0, 1))
    of_scene = 1 + 254 * (thickness - THICKNESS_MIN) / (thickness.max() - THICKNESS_MIN)
    assert np.abs(of_scene - grey)[both].max() <= 1.0
    # What the file shows as cloud, bright in the visible and cold in the infrared, is cold in the thermal infrared.
    assert spearmanr(level[both], radiance[both]).statistic < -0.9
