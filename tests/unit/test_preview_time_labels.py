"""Pictures of a cube say at what time each frame was taken, also where the steps of time are uneven."""

import netCDF4
import numpy as np
import pytest
from PIL import Image

from hcss_twin import Scenario, simulate
from hcss_twin.reports.preview import draw_preview, time_label


@pytest.mark.parametrize(
    ("nanoseconds", "text"),
    [
        (0, "t = 0 s"),
        (1_000_000, "t = 0.001 s"),
        (1_111_104_000_000, "t = 1111.104 s"),
        (1_234_567_000_000_000, "t = 1234567 s"),
    ],
)
def test_times_are_written_in_full(nanoseconds, text):
    start = np.datetime64("2024-04-20T02:30:00", "ns")
    assert time_label(start + np.timedelta64(nanoseconds, "ns"), start) == text


def test_every_frame_of_an_animation_has_its_own_time_above_it(tmp_path):
    scenario = Scenario.load(
        "stratus",
        {
            "image.rows": 20,
            "image.columns": 120,
            "frames.count": 3,
            "motion.evolution_time": "frozen",
            "motion.platform_speed": 0.0,
            "motion.wind_speed": 0.0,
            "output.variables": ["cloud_mask"],
        },
    )
    simulate(scenario, tmp_path / "c.nc").close()
    with netCDF4.Dataset(tmp_path / "c.nc", "a") as file:
        file["time"][:] = file["time"][0] + np.array([0.0, 1.0, 100.0])
    film = next(path for path in draw_preview(tmp_path / "c.nc", tmp_path) if path.suffix == ".gif")
    with Image.open(film) as image:
        frames = []
        for number in range(image.n_frames):
            image.seek(number)
            frames.append(np.asarray(image.convert("L")))
    strip = frames[0].shape[0] - 20
    assert strip > 0
    assert len(frames) == 3
    for frame in frames[1:]:
        # Nothing moves, so that only the label differs.
        np.testing.assert_array_equal(frame[strip:], frames[0][strip:])
        assert not np.array_equal(frame[:strip], frames[0][:strip])
    assert not np.array_equal(frames[1][:strip], frames[2][:strip])
