"""Clear sky over the field of a camera: few nodes where it is smooth, and none computed twice."""

import numpy as np
import pytest
from hcss_payload.live.sea import ClearSky, node_positions, over_field

import hcss_twin
from hcss_twin.engine.tables.radiance_tables import RadianceTables

ROW, COLUMN = (nodes.ravel() for nodes in np.meshgrid(node_positions(), node_positions(), indexing="ij"))


@pytest.mark.parametrize(
    ("field", "computed"),
    [
        (2.0 + ROW - 3.0 * COLUMN**2 + ROW**2 * COLUMN**2, 13),  # of second order
        (2.0 + ROW + 1e-3 * ROW**3 * COLUMN, 13),  # nearly
        (2.0 + ROW + ROW**3 * COLUMN, 25),
        (np.exp(3.0 * ROW + COLUMN), 25),
    ],
)
def test_smooth_fields_are_interpolated_and_others_are_computed(field, computed):
    asked = []

    def value(node):
        asked.append(node)
        return np.array([field[node], -field[node]])

    found = over_field(value, np.array([2e-3, 2e-3]))
    assert len(set(asked)) == len(asked) == computed
    largest = 2e-3 if computed == 13 else 1e-15
    np.testing.assert_allclose(found, np.stack([field, -field], axis=1), rtol=1e-12, atol=largest)


def test_clear_sky_is_computed_once():
    scene = {"bands": ["lwir-10.8"], "time": "2024-04-20T02:30:00Z", "place": {"latitude": 30.0, "longitude": 150.0}}
    models = {"sea": {"model": "cox-munk"}, "radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}}
    image = {"image": {"rows": 8, "columns": 8, "pixel_size": 100.0}}
    scenario = hcss_twin.Scenario.from_dict({**scene, **models, **image})
    count = 0

    def compute():
        nonlocal count
        count += 1
        return ClearSky(np.arange(1.0), np.full((25, 1), 1.0 / 3.0), np.array([0.1]))

    plan = hcss_twin.make_plan(scenario)
    for parts, computed in ((["a", 0.1], 1), (["a", 0.1], 1), (["a", 0.2], 2), (["a", 0.1], 2)):
        found = RadianceTables.recall_beside(plan, parts, compute, (ClearSky,))
        assert count == computed
        np.testing.assert_array_equal(found.views, np.full((25, 1), 1.0 / 3.0))
    warmer = hcss_twin.Scenario.from_dict({**scene, **models, **image, "sea": {**models["sea"], "temperature": 280.0}})
    RadianceTables.recall_beside(hcss_twin.make_plan(warmer), ["a", 0.1], compute, (ClearSky,))
    assert count == 3
