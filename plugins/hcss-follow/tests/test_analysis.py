"""Motion and state of made images whose motion is known."""

from dataclasses import fields
from datetime import timedelta

import numpy as np
import pytest
from conftest import TIME, field, images, state_of
from hcss_follow.analysis import Image, advance, doubts
from hcss_follow.state import read_state

from hcss_twin.providers import CatalogError, ImageError


def test_flow_is_that_of_the_images():
    flow = state_of(images()).flow_m_s[:, 24:-24, 24:-24] * 900.0 / 3000.0
    assert np.sqrt(np.mean((flow[0] - 2.0) ** 2 + (flow[1] + 3.0) ** 2)) < 0.25


def test_what_only_moves_has_no_tendency():
    state = state_of(images())
    inside = (slice(24, -24),) * 2
    change = images()[1].kelvin - images()[0].kelvin
    assert np.std(state.tendency_K[inside]) < 0.15 * np.std(change[inside])
    assert state.agreement > 0.98
    assert not doubts(state)


def test_images_of_other_skies_are_flagged_and_those_of_one_are_not():
    other = [images()[0], Image(field(128, seed=8), TIME + timedelta(minutes=15))]
    assert "do not show one sky" in doubts(state_of(other))[0]
    late = [images()[0], Image(images()[1].kelvin, TIME + timedelta(hours=6))]
    assert any("360 min apart" in note for note in doubts(state_of(late)))
    assert "One image" in doubts(state_of(images()[:1]))[0]


def test_replay_gives_the_same_bits_and_files_keep_them(tmp_path):
    given = images(steps=(0, 1, 2))
    at_once, stepwise = state_of(given), advance(state_of(given[:2]), given[2])
    at_once.write(tmp_path / "state.nc")
    for other in (stepwise, read_state(tmp_path / "state.nc")):
        for entry in fields(at_once):
            np.testing.assert_array_equal(getattr(other, entry.name), getattr(at_once, entry.name))
    assert at_once.number == 3


def test_wrong_images_name_what_is_allowed(tmp_path):
    state = state_of(images())
    later = TIME + timedelta(hours=1)
    with pytest.raises(ImageError, match="allowed: later than"):
        advance(state, Image(field(128), TIME))
    with pytest.raises(ImageError, match=r"\(64, 64\) pixels; allowed: those of the state"):
        advance(state, Image(field(64), later))
    with pytest.raises(ImageError, match="150 to 340 K"):
        advance(state, Image(field(128) - 200.0, later))
    holes = field(128)
    holes[:64] = np.nan
    with pytest.raises(ImageError, match=r"50\.0% of the pixels are missing; allowed: 5%"):
        advance(state, Image(holes, later))
    (tmp_path / "no.nc").write_bytes(b"\x89HDF nothing")
    with pytest.raises(CatalogError, match=r"no\.nc"):
        read_state(tmp_path / "no.nc")


def test_few_missing_pixels_are_interpolated():
    holes = field(128)
    holes[60:62] = np.nan
    whole = state_of([Image(holes, TIME)]).kelvin
    assert np.abs(whole[60:62] - field(128)[60:62]).max() < 1.0
