"""Threads that share a loop."""

import threading

import pytest

from hcss_twin.physics.multiple_scattering.chains import Team


@pytest.mark.parametrize("threads", [1, 2, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 15, 16, 33, 1000])
def test_every_item_is_done_once(threads, count):
    done = []
    with Team(threads) as team:
        for _ in range(2):
            team.run(lambda start, step: done.extend(range(start, count, step)), count)
    assert sorted(done) == sorted([*range(count), *range(count)])


def test_threads_are_started_once_for_several_loops():
    seen, met = set(), threading.Barrier(3)

    def part(start, step):
        seen.add(threading.get_ident())
        met.wait(20)

    with Team(3) as team:
        for _ in range(4):
            team.run(part, 1000)
    assert len(seen) == 3
    assert threading.get_ident() in seen


@pytest.mark.parametrize("failing", [0, 2])
def test_an_error_in_any_part_is_raised_when_the_others_have_ended(failing):
    ended = []

    def part(start, step):
        if start == failing:
            raise RuntimeError(f"part {start}")
        ended.append(start)

    with pytest.raises(RuntimeError, match=f"part {failing}"), Team(3) as team:
        team.run(part, 1000)
    assert sorted(ended) == sorted({0, 1, 2} - {failing})
