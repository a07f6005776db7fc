"""The follower of live frames: the next image becomes the next state, beside the one before, the same each time."""

import json
from datetime import UTC, datetime, timedelta
from importlib.metadata import entry_points

import numpy as np
import pytest
from hcss_follow.analysis import Image, analyse
from hcss_follow.follower import assimilate, followed
from hcss_follow.state import read_state
from scipy.ndimage import gaussian_filter

import hcss_twin
from hcss_twin.providers import CatalogError, ImageError

TIME, STEP = datetime(2020, 9, 6, 0, 15, tzinfo=UTC), timedelta(minutes=15)


def _kelvin(shift):
    """Clouds that move by pixels along rows."""
    noise = gaussian_filter(np.random.default_rng(1).normal(size=(96, 96)), 3.0, mode="wrap")
    return (290.0 - 12.0 * np.clip(np.roll(noise / noise.std(), shift, 1), 0.0, None)).astype(np.float32)


@pytest.fixture
def scenario(tmp_path):
    images = [Image(_kelvin(0), TIME - STEP), Image(_kelvin(1), TIME)]
    analyse(images, pixel_size_m=3000.0, latitude=0.0, longitude=0.0).write(tmp_path / "twin.nc")
    scene = {
        "time": TIME.isoformat(),
        "bands": ["lwir-10.8"],
        "place": {"latitude": 0.0, "longitude": 0.0},
        "image": {"rows": 64, "columns": 64, "pixel_size": 3000.0},
        "motion": {"wind_speed": 0.0},
        "clouds": {"type": "deep-convection", "generator": "followed", "parameters": {"state": "twin.nc", "member": 3}},
    }
    (tmp_path / "twin.json").write_text(json.dumps(scene))
    return hcss_twin.Scenario.load(tmp_path / "twin.json")


def test_an_image_becomes_the_state_of_the_next_scenario(scenario, tmp_path):
    after = followed.assimilated(scenario, _kelvin(2), TIME + STEP)
    (layer,) = json.loads(after.to_json())["clouds"]["layers"]
    assert layer["parameters"] == {"state": str(tmp_path / "twin-3.nc"), "member": 3, "lead": -900.0}
    assert after.time == scenario.time
    state = read_state(tmp_path / "twin-3.nc")
    np.testing.assert_array_equal(state.kelvin, _kelvin(2))
    assert (state.time, state.number, state.interval_s) == (TIME + STEP, 3, 900.0)
    # A pixel in 15 minutes, eastward.
    assert np.median(state.flow_m_s[1]) == pytest.approx(3000.0 / 900.0, rel=0.1)
    assert abs(np.median(state.flow_m_s[0])) < 0.3
    again = followed.assimilated(scenario, Image(_kelvin(2), TIME + STEP), TIME + STEP)
    assert again.to_json() == after.to_json()
    np.testing.assert_array_equal(read_state(tmp_path / "twin-3.nc").flow_m_s, state.flow_m_s)
    later = followed.assimilated(after, _kelvin(3), TIME + 2 * STEP)
    (layer,) = json.loads(later.to_json())["clouds"]["layers"]
    assert layer["parameters"] == {"state": str(tmp_path / "twin-4.nc"), "member": 3, "lead": -1800.0}


def test_what_is_no_later_image_is_refused(scenario, tmp_path):
    with pytest.raises(ImageError, match=r"time: 2020-09-06T00:15:00\+00:00; allowed: later than the state's"):
        followed.assimilated(scenario, _kelvin(2), TIME)
    with pytest.raises(ImageError, match=r"image: \(64, 96\) pixels; allowed: those of the state"):
        followed.assimilated(scenario, _kelvin(2)[:64], TIME + STEP)
    (tmp_path / "half.nc").write_bytes(b"CDF")
    with pytest.raises(CatalogError, match=r"half\.nc"):
        followed.read(tmp_path / "half.nc")
    assert not list(tmp_path.glob("twin-*.nc"))


def test_a_scenario_that_follows_nothing_is_refused(scenario):
    raw = json.loads(scenario.to_json())
    raw["clouds"] = {"type": "stratus", "generator": "fractal", "coverage": 0.3}
    with pytest.raises(ImageError, match=r"generators of clouds are .*fractal; allowed: with followed"):
        followed.assimilated(hcss_twin.Scenario.from_dict(raw), _kelvin(2), TIME + STEP)


@pytest.mark.long
def test_a_twin_takes_the_next_image_and_shows_it_at_its_time(tmp_path):
    """From Python, without a server: the frame at the time of the image is the image."""
    analyse([Image(_kelvin(0), TIME)], pixel_size_m=3000.0, latitude=0.0, longitude=0.0).write(tmp_path / "twin.nc")
    twin = hcss_twin.Twin({
        "time": TIME.isoformat(), "place": {"latitude": 0.0, "longitude": 0.0}, "bands": [[10.3, 11.3]],
        "accuracy": 0.005, "view": {"zenith": 0.0}, "sea": {"temperature": 299.0},
        "image": {"rows": 16, "columns": 16, "pixel_size": 3000.0}, "frames": {"count": 2, "interval": 900.0},
        "motion": {"platform_speed": 0.0, "wind_speed": 0.0}, "slant": {"parallax": "off", "shadows": "off"},
        "clouds": {
            "type": "deep-convection", "base": 500.0, "top": 1500.0, "water_content": 0.6, "thickness_min": 0.01,
            "generator": "followed", "parameters": {"state": str(tmp_path / "twin.nc")},
        },
        "output": {"variables": ["brightness_temperature"]},
    })  # fmt: skip
    for image, time in ((_kelvin(1), None), (Image(_kelvin(1), TIME.replace(tzinfo=None)), None)):
        with pytest.raises(ImageError, match=r"time: .*; allowed: a time with its time zone"):
            assimilate(twin, image, time)
    after = assimilate(twin, _kelvin(5), TIME + STEP)
    before, follows = (
        next(iter(each.frames([number]))).variables["brightness_temperature"][0]
        for each, number in ((twin, 0), (after, 1))
    )
    inside = (slice(40, 56),) * 2
    assert np.sqrt(np.mean((follows - _kelvin(5)[inside]) ** 2)) < 0.15
    np.testing.assert_allclose(before, _kelvin(0)[inside], atol=0.5)
    again = next(iter(assimilate(twin, Image(_kelvin(5), TIME), TIME + STEP).frames([1])))
    np.testing.assert_array_equal(again.variables["brightness_temperature"][0], follows)


def test_live_frames_find_the_follower():
    (entry,) = entry_points(group="hcss_payload.followers", name="followed")
    assert entry.load() is followed
