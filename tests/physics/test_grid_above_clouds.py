"""The spectral grid is fine enough for the air above thick clouds, not for clear sky alone."""

import numpy as np

from hcss_twin import Scenario, make_plan


def test_band_radiance_above_high_cloud_does_not_depend_on_a_finer_grid():
    """Above 10 km, lines of water vapour stand out from a dark window: clear sky alone missed 5e-4."""
    scene = {
        "time": "2024-04-20T22:30:00+10:00",
        "place": {"latitude": 35.0, "longitude": 150.0},
        "image": {"rows": 8, "columns": 8},
        "frames": {"count": 1},
        "view": {"zenith": 60.0},
        "bands": ["swir-2.7-3.0"],
        "accuracy": 1e-4,
        "clouds": {"type": "cirrus", "base": 6000.0, "top": 10000.0},
    }
    plan = make_plan(Scenario.from_dict(scene))
    assembly = plan.assembly
    model, thickest = assembly.at_level(0).model, np.array([[4000.0]])
    coarse, fine = plan.spectral_grid, assembly.refined_grid(plan.grid_refinement.refinement + 2)
    radiance = [
        float((sum(model.cloudy(grid.wavenumber_cm1, thickest, None).values()) @ grid.weights_cm1.T)[0, 0])
        for grid in (coarse, fine)
    ]
    assert abs(radiance[0] / radiance[1] - 1.0) < 1e-4
