"""Measured images, where they are at hand: forecasts against what came, and images that do not belong together."""

import os
from datetime import timedelta
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from conftest import TIME, state_of
from hcss_follow.analysis import Image, doubts
from hcss_follow.motion import moved
from hcss_follow.sky import FollowedSky

FILE = Path(os.environ.get("HCSS_SAMPLE_DATA", "data")) / "seviri/dev-blocks-with-margin-2020-09-06.nc"
pytestmark = pytest.mark.skipif(not FILE.exists(), reason="no measured images; set HCSS_SAMPLE_DATA")
INSIDE = (slice(64, -64),) * 2


def image(block, minute):
    with netCDF4.Dataset(FILE) as file:
        kelvin = np.ma.filled(file[f"IR_108_00{minute:02}"][block], np.nan)[::-1]
    return Image(kelvin, TIME + timedelta(minutes=minute))


@pytest.mark.parametrize("block", [2, 10])
def test_the_forecast_is_better_than_the_flow_alone(block):
    """Block 10 is quiet: with coefficients that ignore the place it is worse than the flow."""
    state = state_of([image(block, 0), image(block, 15)])
    truth = image(block, 45).kelvin[INSIDE]
    at = np.arange(-128.0, 128.0) + 0.5
    errors = [
        np.sqrt(np.mean((forecast - truth) ** 2))
        for forecast in (
            FollowedSky(state, 1).at(1800.0, at, at)[..., 0],
            moved(state.kelvin, state.flow_m_s / np.float32(3000.0), 1800.0)[INSIDE],
            state.kelvin[INSIDE],
        )
    ]
    assert errors[0] < 0.95 * min(errors[1:]), errors


def test_images_of_other_places_are_flagged_and_those_of_one_are_not():
    for block in (0, 9, 17):
        assert not doubts(state_of([image(block, 0), image(block, 15)]))
        assert "do not show one sky" in doubts(state_of([image((block + 5) % 22, 0), image(block, 15)]))[0]
