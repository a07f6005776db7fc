"""The generator `followed`: equal to the image at lead 0, a pure function of time, place and seed."""

from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from conftest import STILL, Emitting, images, seen, state_of
from hcss_author import sample_cloud_inputs
from hcss_follow.analysis import Image, advance
from hcss_follow.generator import FollowedClouds
from hcss_follow.parameters import FollowedParameters

from hcss_twin.providers import ProviderError


def thin_clouds():
    """A state whose second channel says that clouds are thin."""
    first, last = images()
    return state_of([first, replace(last, second_K=last.kelvin - np.where(last.kelvin < 288.0, 3.0, 0.5))])


MIDDLE = (slice(48, 80),) * 2


@pytest.mark.parametrize("member", [None, 3])
def test_lead_0_is_the_image(make, member):
    state = state_of(images())
    error = seen(make(state, member=member)) - state.kelvin[MIDDLE]
    assert np.abs(error).max() < 0.05


def test_lead_0_is_the_image_up_to_its_edge_with_deep_cloud(make):
    given = images()
    deep = [Image(np.where(image.kelvin < 285.0, image.kelvin - 60.0, image.kelvin), image.time) for image in given]
    state = state_of(deep)
    whole = make(state, 128, 128)
    error = seen(whole, 0.0, slice(0, 128), slice(0, 128)) - state.kelvin
    assert state.kelvin.min() < 225.0
    assert np.sqrt(np.mean(error**2)) < 0.05


def test_heights_of_thin_cloud_are_kept(make):
    thin, opaque = make(thin_clouds()), make(state_of(images()))
    span = (0.0, slice(0, 32), slice(0, 32))
    np.testing.assert_allclose(seen(thin), seen(opaque), atol=0.1)
    assert thin.cloud_top_m(*span).mean() > opaque.cloud_top_m(*span).mean() + 300.0


def test_windows_are_parts_of_the_whole_to_the_bit(make):
    generator = make(state_of(images()), 96, 96, member=5)
    rows = columns = slice(-30, 130)  # beyond the image of 128 pixels, whose middle is that of the scene
    for time_s in (0.0, 1234.0):
        whole = generator.thickness_around_m(time_s, rows, columns)
        tops = generator.cloud_top_m(time_s, rows, columns)
        for i, j, height, width in ((-30, -30, 7, 50), (17, 40, 21, 1), (99, 5, 31, 80)):
            window = slice(i, i + height), slice(j, j + width)
            part = (slice(i + 30, i + 30 + height), slice(j + 30, j + 30 + width))
            np.testing.assert_array_equal(generator.thickness_around_m(time_s, *window), whole[part])
            np.testing.assert_array_equal(generator.cloud_top_m(time_s, *window), tops[part])


def test_small_pixels_have_the_mean_of_the_image(make):
    state = thin_clouds()
    coarse = make(state).thickness_m(0.0, slice(8, 24), slice(8, 24)).astype(float)
    fine = make(state, 256, 256, 375.0).thickness_m(0.0, slice(64, 192), slice(64, 192)).astype(float)
    means = fine.reshape(16, 8, 16, 8).mean(axis=(1, 3))
    np.testing.assert_allclose(means, coarse, rtol=0.02, atol=0.05)
    assert fine.std() > coarse.std()


def test_seed_and_member_matter_later_and_order_does_not(make):
    state = state_of(images())
    one, other = make(state, member=1), make(state, member=2)
    span = slice(0, 32), slice(0, 32)
    assert not np.array_equal(one.cloud_top_m(900.0, *span), other.cloud_top_m(900.0, *span))
    later = make(state, member=1)
    later.thickness_m(0.0, *span)
    np.testing.assert_array_equal(later.cloud_top_m(900.0, *span), one.cloud_top_m(900.0, *span))


def test_the_next_state_takes_over_without_a_jump(make):
    given = images(steps=(0, 1, 2))
    state = state_of(given[:2])
    before = make(state)
    after = before.assimilate(advance(state, given[2]), 900.0, 60.0)
    np.testing.assert_array_equal(seen(after, 899.9), seen(before, 899.9))
    steps = np.array([seen(after, time_s) for time_s in np.arange(880.0, 980.0, 1.0)])
    change = np.abs(np.diff(steps, axis=0)).max(axis=(1, 2))
    assert change.max() < 1.0
    # long after, it is the sky of the new state alone
    alone = make(advance(state, given[2]))
    np.testing.assert_allclose(seen(after, 1800.0), seen(alone, 900.0), atol=1e-3)


def test_a_state_of_another_place_is_refused(make):
    state = state_of(images())
    generator = make(state)
    with pytest.raises(ProviderError, match="pixels of 2000 m"):
        generator.assimilate(replace(state, pixel_size_m=2000.0), 0.0)
    with pytest.raises(ProviderError, match="no earlier than"):
        generator.assimilate(replace(state, time=state.time - timedelta(hours=1)), 0.0)


def test_without_a_scene_it_says_so(tmp_path):
    with pytest.raises(ProviderError, match="allowed: in a scenario"):
        FollowedClouds(sample_cloud_inputs(0.5, 1), FollowedParameters(state="x.nc"))


def test_platform_and_lead_move_the_scene(make):
    state = state_of(images())
    still = make(state)
    moving = make(state, motion=replace(STILL, platform_speed_m_s=3000.0))
    np.testing.assert_allclose(seen(moving, 3.0)[:, :-3], seen(still, 3.0)[:, 3:], atol=1e-3)
    np.testing.assert_allclose(seen(make(state, lead=600.0)), seen(still, 600.0), atol=1e-4)


def test_emitting_is_what_the_tests_take_it_for():
    assert Emitting().of(np.array(2000.0), np.array(1e6)) == pytest.approx(285.0)
