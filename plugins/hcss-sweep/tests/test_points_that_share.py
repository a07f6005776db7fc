"""What points of a sweep share: curves of reference columns, and the air over seas of several temperatures."""

from hcss_sweep import sweep
from hcss_sweep.points import SweepPoint, points_with_curves

from hcss_twin import Scenario, simulate


def test_the_second_point_of_a_group_and_small_groups_solve_all_columns():
    points = [SweepPoint(number, {}, Scenario.load("stratus", {"seed": number})) for number in range(40)]
    groups = {point.number: "few" if point.number < 3 else "many" for point in points}
    assert points_with_curves(points, groups) == set(range(40)) - {0, 1, 2, 4}


def test_points_over_seas_of_several_temperatures_are_those_of_their_scenarios_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    scene = {
        "bands": ["lwir-10.8"],
        "accuracy": 1e-2,
        "image.rows": 6,
        "image.columns": 8,
        "frames.count": 1,
        "output.certificate": 2,
    }
    kelvin = [288.0, 289.2, 290.1]
    result = sweep("stratus", tmp_path / "sweep", over={"sea.temperature": kelvin}, overrides=scene)
    assert not result.failed
    for number in (0, 2):
        simulate(Scenario.load("stratus", scene | {"sea.temperature": kelvin[number]}), tmp_path / "alone.nc").close()
        assert result.cube(number).read_bytes() == (tmp_path / "alone.nc").read_bytes()


def test_points_that_differ_in_their_seed_are_those_of_their_scenarios_alone(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    scene = {"bands": ["lwir-10.8"], "accuracy": 1e-2, "image.rows": 6, "image.columns": 8, "frames.count": 1}
    scene |= {"output.certificate": 2}
    result = sweep("stratus", tmp_path / "sweep", over={"seed": [1, 2, 3]}, overrides=scene)
    assert not result.failed
    for number in (0, 2):
        simulate(Scenario.load("stratus", scene | {"seed": number + 1}), tmp_path / "alone.nc").close()
        assert result.cube(number).read_bytes() == (tmp_path / "alone.nc").read_bytes()
