"""Frames in memory are those of the cube."""

import numpy as np
import pytest
from cheap import CHEAP, NARROW

import hcss_twin
from hcss_twin.engine.certificate.certificate import Certificate

SMALL = CHEAP | {
    "bands": NARROW,
    "image.rows": 24,
    "image.columns": 32,
    "frames.count": 3,
    "frames.interval": 600.0,
    "output.certificate": 8,
}


def scenario(**changes):
    return hcss_twin.Scenario.load("stratus", SMALL | changes)


def test_frames_and_certificate_are_those_of_the_cube():
    own = scenario()
    twin, cube = hcss_twin.Twin(own), hcss_twin.simulate(own)
    frames = list(twin.frames())
    assert [frame.number for frame in frames] == [0, 1, 2]
    assert {"radiance", "cloud_mask"} <= set(frames[0].variables)
    for frame in frames:
        assert frame.time_s == twin.plan.frame_times_s[frame.number]
        for name, values in frame.variables.items():
            stored = cube[name].values[frame.number]
            assert values.dtype == stored.dtype
            assert values.tobytes() == stored.tobytes(), name
    assert frames[0].radiance is frames[0].variables["radiance"]
    certificate = twin.certificate()
    assert isinstance(certificate, Certificate)
    written = certificate.attributes()
    assert {name: cube.attrs[name] for name in written} == pytest.approx(written)


def test_a_frame_does_not_depend_on_those_before():
    twin = hcss_twin.Twin(scenario())
    every = [frame.radiance for frame in twin.frames()]
    last, first = (frame.radiance for frame in twin.frames([2, 0]))
    assert np.array_equal(last, every[2])
    assert np.array_equal(first, every[0])


def test_frames_that_do_not_exist_are_refused_before_any_is_computed():
    with pytest.raises(hcss_twin.ScenarioError, match="number 3 asked for; allowed: 0 to 2"):
        hcss_twin.Twin(scenario()).frames([0, 3])


def test_no_certificate_without_pixels():
    assert hcss_twin.Twin(scenario(**{"output.certificate": 0})).certificate() is None
