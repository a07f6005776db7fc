"""Frames between keyframes: those of cubes at keyframes, without a jump where a new state begins, the same again."""

import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hcss_payload.checks import PayloadError
from hcss_payload.live import PointTarget, live_pass
from hcss_payload.live.folder_watch import SETTLED_S, FolderWatch
from hcss_payload.pose import Pose
from scipy.spatial.transform import Rotation

import hcss_twin

SCENE = {
    "seed": 3,
    "time": "2024-04-20T02:30:00Z",
    "bands": [{"name": "lwir", "limits": [10.5, 11.0]}],
    "place": {"latitude": 30.0, "longitude": 150.0},
    "image": {"rows": 64, "columns": 64, "pixel_size": 200.0},
    "frames": {"count": 2, "interval": 120.0},
    "motion": {"wind_speed": 10.0},
    "clouds": {"type": "stratus", "generator": "fractal", "coverage": 0.3, "coverage_mode": "field"},
    "sea": {"wind_speed": 10.0, "model": "cox-munk", "waves": "off"},
    "slant": {"shadows": "off"},
    "radiance": {"model": "as-printed"},
    "optics": {"provider": "mie"},
    "camera": {"rows": 40, "columns": 48, "focal_length": 1.0, "detector_pitch": 8e-6, "points": 1},
    "orbit": {"provider": "geostationary", "longitude": 140.0},
    "attitude": {"provider": "track"},
}
IMAGE, TIME = np.full((8, 8), 0.8), datetime(2024, 4, 20, tzinfo=UTC)
STEP_S, KEYFRAME_S, MARGIN_PX, PATIENCE_S = 0.5, 2.0, 6.0, 120.0


@pytest.fixture(autouse=True)
def processes_find_the_follower(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))


def _live(**options):
    scenario = hcss_twin.Scenario.from_dict(SCENE)
    follower = {"follower": "cover_follower:cover", "keyframe_s": KEYFRAME_S} | options
    return live_pass(scenario, method="keyframes", threads=1, margin_px=MARGIN_PX, **follower)


def _until(condition):
    until = time.monotonic() + PATIENCE_S
    while not condition() and time.monotonic() < until:
        time.sleep(0.02)
    assert condition()


def _jump(frames):
    """Return the largest difference between frames over the larger one of those beside it."""
    away = np.abs(np.diff(np.stack(frames), axis=0)).mean(axis=(1, 2, 3))
    return float(np.max(away[1:-1] / np.maximum(away[:-2], away[2:])))


def test_a_new_state_begins_without_a_jump_and_a_replay_has_the_same_bits():
    times_s = STEP_S * np.arange(101)
    with _live() as live, live_pass(hcss_twin.Scenario.from_dict(SCENE), method="cube", margin_px=MARGIN_PX) as cube:
        assert (live.keyframe_s, live.blend_s, live.state_number) == (KEYFRAME_S, 10.0, 0)
        for time_s in (0.0, 2.0, 4.0):
            shown, exact = live.frame(time_s).radiance, cube.frame(time_s).radiance
            assert np.sqrt(np.mean((shown - exact) ** 2)) < 2e-3 * exact.std()
        # Between them the clouds have moved: less than they do from one keyframe to the next.
        shown, exact = live.frame(5.0).radiance, cube.frame(5.0).radiance
        assert np.sqrt(np.mean((shown - exact) ** 2)) < np.std(cube.frame(6.0).radiance - cube.frame(4.0).radiance)
        with pytest.raises(PayloadError, match=r"begins_s: 2 s; allowed: \d+ s or later, since keyframes"):
            live.assimilate(IMAGE, TIME, begins_s=2.0)
        assert live.assimilate(IMAGE, TIME) == 1
        _until(lambda: live.look() == [] and live.states)
        (change,) = live.states
        assert change.ends_s == change.begins_s + 10.0
        first = [(live.frame(float(at)).radiance, live.state_number) for at in times_s]
        # An image that is none changes nothing, and the next one has the next number.
        assert live.assimilate(100.0 * IMAGE, TIME) == 2
        refused = list[str]()
        _until(lambda: refused.extend(live.look()) or refused)
        assert refused == ["state 2: image: a mean of 80; allowed: 0 to 1"]
        assert np.array_equal(live.frame(float(times_s[-1])).radiance, first[-1][0])
        with pytest.raises(PayloadError, match=r"time_s: keyframe at 0 s belongs to a state that is over"):
            live.frame(0.0)
    numbers = [number for _, number in first]
    assert numbers == [int(at >= change.begins_s) for at in times_s]
    frames = [radiance for radiance, _ in first]
    assert frames[-1].mean() < frames[0].mean() - 0.3 * frames[0].std()  # more clouds, which are colder
    assert _jump(frames) < 1.5
    # A state that begins at once is seen.
    begun = numbers.index(1)
    assert _jump([*frames[:begun], *frames[-40:]]) > 3.0
    with _live() as again:
        assert again.assimilate(IMAGE, TIME, begins_s=change.begins_s) == 1
        for time_s, (radiance, number) in zip(times_s, first, strict=True):
            assert np.array_equal(again.frame(float(time_s)).radiance, radiance)
            assert again.state_number == number
        assert again.states == (change,)


def test_what_keyframes_cannot_show_is_named():
    with _live(follower=None, keyframe_s=None) as live:
        assert 0.5 <= live.keyframe_s <= 32.0
        assert live.errors["keyframes"] > 0.0
        with pytest.raises(PayloadError, match="nothing makes a state of an image in this scene"):
            live.assimilate(IMAGE, TIME)
        with pytest.raises(PayloadError, match=r"targets: between keyframes there are none"):
            live.frame(0.0, targets=[PointTarget(30.0, 150.0, 0.0, (1.0,))])
        pose = live._payload.pose(1.0)
        for pixels, is_shown in ((4.0, True), (40.0, False)):
            turned = pose.rotation * Rotation.from_rotvec([8e-6 * pixels, 0.0, 0.0])
            moved = Pose(1.0, pose.position_m, turned.as_quat())
            if is_shown:
                # Shifted by whole pixels, the image is the same.
                np.testing.assert_allclose(
                    live.frame(1.0, moved).radiance[:, 4:], live.frame(1.0, pose).radiance[:, :-4], rtol=2e-2
                )
            else:
                with pytest.raises(PayloadError, match="farther than 6 pixels beside the nominal pass"):
                    live.frame(1.0, moved)
    with pytest.raises(PayloadError, match="a pass with some duration"):
        live_pass(hcss_twin.Scenario.from_dict(SCENE), 1.0, 1.0, method="keyframes")
    with live_pass(hcss_twin.Scenario.from_dict(SCENE), method="fast") as fast:
        assert fast.look() == []
        with pytest.raises(PayloadError, match="frames of method 'fast' follow no images"):
            fast.assimilate(IMAGE, TIME)


def test_a_file_is_taken_once_when_it_is_whole(tmp_path):
    (tmp_path / "old.npy").write_bytes(b"old")
    watch = FolderWatch(tmp_path)
    for name in ("new.npy", ".hidden", "loading.npy.part", "empty.npy"):
        (tmp_path / name).write_bytes(b"" if name == "empty.npy" else b"half")
    (tmp_path / "folder").mkdir()
    assert watch.new(0.0) == []
    (tmp_path / "new.npy").write_bytes(b"half and half")  # still being written
    assert watch.new(SETTLED_S) == []
    assert watch.new(2.0 * SETTLED_S - 0.1) == []
    assert watch.new(2.0 * SETTLED_S) == [tmp_path / "new.npy"]
    assert watch.new(9.0 * SETTLED_S) == []
    # A file that changes later is another image; one that is renamed into its place as well.
    (tmp_path / "loading.npy.part").rename(tmp_path / "loading.npy")
    (tmp_path / "old.npy").write_bytes(b"newer")
    assert watch.new(10.0 * SETTLED_S) == []
    assert {path.name for path in watch.new(11.0 * SETTLED_S)} == {"loading.npy", "old.npy"}
