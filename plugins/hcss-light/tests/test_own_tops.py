"""Light between clouds with tops of their own: where all have one top it is that of a flat layer, and Monte Carlo."""

import numpy as np
import pytest
from hcss_light.comparison import check, compare
from hcss_light.relief import FractalClouds
from light_scene import scene
from test_light_along_rays import Arc

from hcss_twin import simulate
from hcss_twin.engine.compile import tables_of
from hcss_twin.plan.make_plan import make_plan

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


@pytest.fixture
def towers(tops):
    """Tops of neighbouring stripes of fractal clouds differ by 500 m."""
    tops((-500.0, 0.0), lambda top, points: (top - 500.0 * (points // 4 % 2)).astype(np.float32))


LOW = {"type": "stratocumulus", "base": 1400.0, "top": 1800.0}
MIDDLE = {"type": "altocumulus", "base": 2500.0, "top": 2900.0}
HIGH = {"type": "paper-cirrus"}
FIELD = {"generator": "fractal", "coverage": 0.4, "coverage_mode": "field"}
TWO, TWO_NEAR = ({"clouds": {"layers": [layer | FIELD for layer in (LOW, other)]}} for other in (HIGH, MIDDLE))
WIDE = {"platform": {"altitude": 2e5}}


@pytest.mark.parametrize(
    "changes",
    [{}, {"bands": [[3.6, 3.8]]}, WIDE | {"accuracy": 1e-3}, TWO, WIDE | TWO_NEAR | {"accuracy": 1e-3}],
    ids=["parallel rays", "3.7 um", "view of each pixel", "two layers", "two layers, view of each pixel"],
)
def test_towers_and_low_clouds_beside_each_other_agree_with_monte_carlo(towers, changes):
    plan = make_plan(of("source", **changes))
    assert plan.views.varies == ("platform" in changes)
    assert plan.assembly.hanging_layers == tuple(range(len(plan.layers)))
    (band,) = compare(of("source", **changes), pixels=24, photons=1500, frame=0, seed=3)["bands"]
    cube, columns = (band["errors"][name] for name in ("cube", "columns"))
    assert abs(cube["bias"]) < 1e-3 + 2.0 * band["noise"]
    # Toward the view of each pixel, in the thermal infrared, columns err by .35 % (one layer) and .24 % (two), the cube
    # by .27 and .22 %.
    gain = (0.95 if "clouds" in changes else 0.85) if "platform" in changes else 0.5
    assert cube["rms"] < gain * columns["rms"]


@pytest.mark.parametrize("clouds", [{}, TWO], ids=["one layer", "two layers"])
def test_rays_that_form_no_grid_on_the_ground_see_what_monte_carlo_does(towers, clouds):
    error = {}
    for light in ("source", "columns"):
        plan = make_plan(of(light, certificate=8, view={}, **clouds), rays=lambda *_: Arc(0.1))
        (error[light],) = check(plan, tables_of(plan), 0)["bands"].values()
    assert abs(error["source"]["bias"]) < 2e-3 + 2.0 * error["source"]["noise"]
    assert error["source"]["rms"] < 0.5 * error["columns"]["rms"]
