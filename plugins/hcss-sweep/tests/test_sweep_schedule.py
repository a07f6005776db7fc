"""Points that share tables: one first, the others after it, none forgotten and none twice."""

import pytest
from cheap import APART, CHEAP
from hcss_sweep.points import Schedule, shared_tables
from hypothesis import given
from hypothesis import strategies as st

from hcss_twin import Scenario, make_plan
from hcss_twin.engine.tables.table_key import table_key


@given(
    st.lists(st.sampled_from("abc"), max_size=12),
    st.integers(1, 4),
    st.sets(st.sampled_from("abc")),
    st.randoms(use_true_random=False),
)
def test_everything_is_done_once_and_no_group_is_begun_twice_before_one_of_it_succeeded(
    groups, workers, opened, random
):
    schedule = Schedule(list(enumerate(groups)), lambda item: item[1], opened)
    under_way, done, succeeded = [], [], set(opened)
    while True:
        while len(under_way) < workers and (following := schedule.next()) is not None:
            index, (number, group) = following
            assert index == number
            assert group in succeeded or group not in [groups[number] for number in under_way]
            under_way.append(number)
        if not under_way:
            break
        number = under_way.pop(random.randrange(len(under_way)))
        success = random.random() < 0.7
        schedule.finished(number, success)
        done.append(number)
        if success:
            succeeded.add(groups[number])
    assert sorted(done) == list(range(len(groups)))


SMALL = APART | CHEAP | {"image.rows": 8, "image.columns": 8, "frames.count": 1, "bands": ["lwir-10.8"]}


def keys_of(scenario):
    return shared_tables(scenario), table_key(make_plan(scenario))


@pytest.fixture(scope="module")
def usual():
    return keys_of(Scenario.load("stratus", SMALL))


@pytest.mark.parametrize(
    ("changes", "same"),
    [
        ({"seed": 5}, True),
        ({"title": "another"}, True),
        ({"image.rows": 16}, True),
        ({"clouds.coverage": 0.2}, True),
        ({"clouds.parameters": {"gamma": 2.2}}, True),
        ({"output.certificate": 3}, True),
        ({"clouds.coverage": 0.0}, False),
        ({"clouds.top": 900.0}, False),
        ({"view.zenith": 30.0}, False),
        ({"time": "2024-07-20T12:30:00+10:00"}, False),
        ({"place.latitude": 10.0}, False),
    ],
)
def test_points_go_together_where_their_tables_are_the_same(usual, changes, same):
    found = keys_of(Scenario.load("stratus", SMALL | changes))
    assert [one == other for one, other in zip(found, usual, strict=True)] == [same, same]
