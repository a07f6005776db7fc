"""Points of a sweep that share curves of reference columns, or columns between temperatures of the sea."""

import numpy as np
from hcss_sweep.points import SweepPoint, points_with_curves, sea_groups

from hcss_twin import Scenario
from hcss_twin.engine.certificate.reference_columns import AFRESH_COLUMNS
from hcss_twin.plan.between_sea_temperatures import ALL_COLUMNS, SeaTemperatures


def test_the_second_point_of_a_group_and_small_groups_solve_all_columns():
    points = [SweepPoint(number, {}, Scenario.load("stratus", {"seed": number})) for number in range(40)]
    groups = {point.number: "few" if point.number < 3 else "many" for point in points}
    assert points_with_curves(points, groups) == set(range(40)) - {0, 1, 2, 4}


def test_scenes_that_differ_in_more_than_the_sea_temperature_are_other_groups_and_some_are_certified_afresh():
    scenarios = [
        Scenario.load("stratus", {"sea.temperature": kelvin, "sea.wind_speed": wind, "seed": seed})
        for wind, seed in ((8.0, 1), (8.0, 2), (9.0, 1))
        for kelvin in np.linspace(288.0, 290.0, 8).tolist()
    ]
    groups = sea_groups([*scenarios, Scenario.load("stratus", {"sea.wind_speed": 7.0})])
    assert groups[-1] is None
    assert all(isinstance(group, SeaTemperatures) for group in groups[:-1])
    assert groups[0].group == groups[7].group
    assert len({groups[number].group for number in (0, 8, 16)}) == 3
    assert not groups[0].afresh
    assert groups[1].afresh == groups[17].afresh == ALL_COLUMNS
    assert {group.afresh for group in groups[2:8]} <= {0, AFRESH_COLUMNS}
    without_certificates = sea_groups(scenarios, certified=False)
    assert without_certificates[0].group == without_certificates[8].group != without_certificates[16].group
    assert not any(group.afresh for group in without_certificates)
