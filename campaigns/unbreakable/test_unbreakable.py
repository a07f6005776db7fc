"""A fixed sample of the campaign."""

import itertools

import air_rows
import limits
import pytest
import schema_scenarios
from schema_keys import groups, trials


def test_every_bound_has_two_sides_and_every_key_a_value():
    every, without = trials()
    assert not without
    # Optional numbers without unit had no limits in the JSON schema.
    assert {"atmosphere.water_vapour_scale", "clouds.effective_variance", "sensor.seed"} <= {
        each.key for each in every if each.end
    }
    sides = {(trial.key, trial.end, trial.side) for trial in every if trial.end}
    for key, end, _ in sides:
        assert {(key, end, "inside"), (key, end, "outside")} <= sides
    inside, beyond = groups()
    assert sorted(trial.name for trial in itertools.chain(*inside, *beyond)) == sorted(trial.name for trial in every)


def test_values_beyond_bounds_are_refused_with_the_names_of_their_keys(tmp_path):
    schema_scenarios.write_files(tmp_path)
    inside, beyond = groups()
    first = len(inside)
    for number in range(first, first + len(beyond), 6):
        outcome, touched, message = schema_scenarios.outcome_of(number, tmp_path)
        assert (outcome, message) == ("refused", "")
        assert len(touched) == len(beyond[number - first])


@pytest.mark.parametrize("number", [6, 7, 28])
def test_absorber_amounts_under_inversions_are_those_of_an_independent_integration(number, tmp_path):
    """With rays followed over r cos(zenith), these were wrong by 19 % at 60 degrees, 46 % at 85, or not a number."""
    assert air_rows.outcome_of("good", number, tmp_path, runs=False) == ("good", "")


@pytest.mark.parametrize("number", range(0, 100, 21))
def test_air_that_cannot_exist_is_refused_by_key_or_line(number, tmp_path):
    outcome, message = air_rows.outcome_of("bad", number, tmp_path, runs=False)
    assert outcome == "refused", message


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("clouds.water_content", 1e-6, "runs"),
        ("platform.detector_pitch", 1e-300, "refused"),  # by the pixels that follow
        ("elements.0.parameters.tracks.0.x of point-sources", 1e8, "runs"),
    ],
)
def test_numbers_at_their_limits_run_or_are_refused_and_no_model_is_blamed(key, value, expected, tmp_path):
    own = next([name, value, context] for name, _, context in limits.trials()[0] if name == key)
    assert limits.outcome_of([own], True, tmp_path)[0] == expected


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("clouds.water_content", 1e-30),
        ("clouds.thickness_min", 1e-300),
        ("clouds.top", 1e-30),
        ("elements.0.parameters.tracks.0.x of point-sources", 1e300),
        ("elements.0.parameters.tracks.0.y of point-sources", float("nan")),
    ],
)
def test_numbers_that_were_accepted_and_then_blamed_on_a_model_are_refused(key, value, tmp_path):
    own = next([name, value, context] for name, _, context in limits.trials()[0] if name == key)
    assert limits.outcome_of([own], False, tmp_path)[0] == "refused"
