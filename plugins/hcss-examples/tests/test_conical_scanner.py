"""A third geometry of rays: against the same sea on a grid, and through clouds."""

import json
from pathlib import Path

import numpy as np
import pytest

from hcss_twin import Scenario, make_plan, simulate

SCENARIO = Path(__file__).parents[1] / "scenarios" / "conical-scanner.toml"
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk"}
ARC = {"clouds.type": "cumulus", "conical_scanner": {"half_arc": 20.0, "rows": 24, "columns": 48}}


def of(**overrides):
    return Scenario.load(SCENARIO, CHEAP | ARC | {"output.variables": ["radiance"]} | overrides)


def test_clear_pixels_have_the_radiance_of_their_views():
    clear = {"clouds.coverage": 0.0, "sea.temperature_texture": 0.0, "atmosphere.water_vapour_texture": 0.0}
    arc = simulate(of(**clear))
    assert arc.attrs["hcss_certificate"].startswith("PASSED")
    for column, azimuth in ((0, 180.0 - 20.0 * 47 / 48), (31, 180.0 + 20.0 * 15 / 48)):
        grid = {"view.zenith": 53.0, "view.azimuth": azimuth, "image.rows": 8, "image.columns": 8}
        raw = json.loads(of(**clear, **grid).to_json())
        del raw["conical_scanner"]
        grid = simulate(Scenario.from_dict(raw))
        assert arc["radiance"].values[0, :, :, column] == pytest.approx(
            np.tile(grid["radiance"].values[0, :, :1, 0], 24), rel=2e-3
        )


def test_clouds_are_seen_and_certified_where_rays_meet_their_layer():
    cube = simulate(of(**{"output.variables": ["radiance", "cloud_fraction"]}))
    assert cube.attrs["hcss_certificate"].startswith("PASSED")
    assert cube["cloud_fraction"].values.mean() == pytest.approx(0.4, abs=0.05)
    assert "clear in shadow" in cube.attrs["hcss_certificate_strata"]
    rays = make_plan(of()).rays
    low, high = (np.stack(rays.points_m((slice(0, 24), slice(0, 48)), 0.0, height)) for height in (0.0, 1000.0))
    # A line at zenith 53 degrees passes a height h tan(53 degrees) nearer to the platform.
    assert np.hypot(*(high - low)) == pytest.approx(np.full(high.shape[1:], 1000.0 * np.tan(np.radians(53.0))))
    assert np.all((high - low)[1] < 0.0)


def test_what_needs_more_of_the_rays_is_refused():
    with pytest.raises(Exception, match=r"clouds\.coverage_mode: 'frame'.*allowed: 'field'"):
        make_plan(of(**{"clouds.coverage_mode": "frame"}))


def test_clouds_that_do_not_state_it_have_the_coverage_of_the_whole_sky():
    raw = json.loads(of(**{"frames.count": 1}).to_json())
    del raw["clouds"]["layers"][0]["coverage_mode"]
    assert Scenario.from_dict(raw).clouds.layers[0].coverage_mode == "field"
    del raw["conical_scanner"]
    assert Scenario.from_dict(raw).clouds.layers[0].coverage_mode == "frame"
