"""A film is one sky for sensors of any pixel size in one sweep."""

import numpy as np
import pytest

import hcss_twin

sweep = pytest.importorskip("hcss_sweep").sweep


def test_coarse_sensors_see_the_means_of_the_clouds_of_a_film(tmp_path):
    sensors = [
        {"name": f"pixels of {pixel_m}", "image": {"rows": count, "columns": count, "pixel_size": pixel_m}}
        for count, pixel_m in ((512, 30.0), (32, 480.0), (8, 1920.0))
    ]
    raw = {
        "time": "2024-07-20T12:40:00+09:00",
        "place": {"latitude": 30.0, "longitude": 140.0},
        "clouds": {"type": "cumulus", "coverage": 0.4},
        "frames": {"count": 1},
        "bands": ["lwir"],
        "output": {"variables": ["cloud_thickness", "cloud_mask"]},
        "sensors": sensors,
    }
    result = sweep(raw, tmp_path / "sky")
    assert not result.failed, result.failed
    seen = []
    for record in result.points:
        with hcss_twin.open_cube(result.cube(record.point)) as cube:
            assert "simulation" in cube.attrs["hcss_scenario"]
            seen.append(cube.cloud_thickness.values[0].astype(float))
    for coarse in seen[1:]:
        count = len(coarse)
        means = seen[0].reshape(count, 512 // count, count, 512 // count).mean((1, 3))
        assert np.corrcoef(coarse.ravel(), means.ravel())[0, 1] > 0.99
        assert coarse.mean() == pytest.approx(means.mean(), rel=0.02)
