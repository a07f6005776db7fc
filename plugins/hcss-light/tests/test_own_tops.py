"""Light between clouds with tops of their own: where all have one top it is that of a flat layer, and Monte Carlo."""

import numpy as np
import pytest
from hcss_light.comparison import compare
from hcss_light.relief import FractalClouds
from light_scene import scene

from hcss_twin import make_plan, simulate

IMAGE = {"rows": 24, "columns": 24, "pixel_size": 100.0}


@pytest.fixture
def tops(monkeypatch):
    """Gives fractal clouds tops of their own: functions of the top of their layer and of the columns of points."""

    def given(range_m, top_m):
        def tops_of(clouds, time_s, rows, columns):
            points = np.arange(columns.start, columns.stop, dtype=np.float32)
            return np.broadcast_to(top_m(clouds._layer.top_m, points), (rows.stop - rows.start, points.size)).copy()

        ends = property(lambda clouds: tuple(clouds._layer.top_m + np.array(range_m)))
        monkeypatch.setattr(FractalClouds, "cloud_top_range_m", ends, raising=False)
        monkeypatch.setattr(FractalClouds, "cloud_top_m", tops_of, raising=False)

    return given


def of(light, **changes):
    """Return a scene whose clouds hang from 1800 m, which is displaced by 18 points."""
    clouds = {"type": "stratocumulus", "base": 1400.0, "top": 1800.0, "coverage": 0.5, "coverage_mode": "field"}
    clouds["generator"] = "fractal"
    view, slant = {"zenith": 45.0, "azimuth": 0.0}, {"shadows": "off", "parallax": "on"}
    return scene(light, **{"clouds": clouds, "image": IMAGE, "view": view, "slant": slant} | changes)


def test_clouds_whose_tops_are_all_that_of_the_layer_are_those_of_a_flat_layer(tops):
    flat = {light: simulate(of(light))["radiance"].values[0, 0].astype(float) for light in ("columns", "source")}
    tops((-50.0, 0.0), lambda top, points: np.full(points.shape, top, np.float32))
    assert make_plan(of("source")).assembly.tops_vary
    own = simulate(of("source"))["radiance"].values[0, 0].astype(float)
    error, sides = (np.sqrt(np.mean((other / flat["source"] - 1.0) ** 2)) for other in (own, flat["columns"]))
    assert sides > 5e-3
    assert error < 0.2 * sides


def test_towers_and_low_clouds_beside_each_other_agree_with_monte_carlo(tops):
    """Tops of neighbouring stripes differ by 500 m."""
    tops((-500.0, 0.0), lambda top, points: (top - 500.0 * (points // 4 % 2)).astype(np.float32))
    (band,) = compare(of("source"), pixels=24, photons=1500, frame=0, seed=3)["bands"]
    cube, columns = (band["errors"][name] for name in ("cube", "columns"))
    assert abs(cube["bias"]) < 1e-3 + 2.0 * band["noise"]
    assert cube["rms"] < 0.5 * columns["rms"]
