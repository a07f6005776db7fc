"""The error stated for the spectral grid holds for the air above thick clouds, not for clear sky alone."""

import numpy as np

from hcss_twin import Scenario, make_plan


def test_error_of_the_grid_holds_above_high_clouds():
    """Above 10 km, lines of water vapour stand out from a dark window; clear sky stated half of this error."""
    scene = {
        "time": "2027-07-06T14:16:00Z",
        "place": {"latitude": -24.6, "longitude": -144.6},
        "image": {"rows": 8, "columns": 8},
        "frames": {"count": 1},
        "view": {"zenith": 60.0},
        "bands": ["swir-2.7-3.0"],
        "accuracy": 1e-4,
        "atmosphere": {"provider": "table"},
        "sea": {"temperature": 277.47},
        "clouds": {"type": "cirrus", "base": 6000.0, "top": 10000.0},
    }
    plan = make_plan(Scenario.from_dict(scene))
    assembly, refinement = plan.assembly, plan.grid_refinement.refinement
    coarsest, thickest = assembly.at_level(0), np.array([[4000.0]])

    def radiance(refinement):
        grid = assembly.refined_grid(refinement)
        spectrum = sum(coarsest.cloudy(grid.wavenumber_cm1, thickest, None).values())
        return float((spectrum @ grid.weights_cm1.T)[0, 0])

    change = abs(radiance(refinement) / radiance(refinement + 1) - 1.0)
    assert 0.0 < change <= 1.0001 * plan.grid_refinement.error
