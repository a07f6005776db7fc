"""Scores against hand-counted cases, the mistake of copied scorers among them; baselines; the command."""

import csv
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from hcss_dataset import DatasetError
from hcss_dataset.baselines import BASELINES, detect
from hcss_dataset.make import make_dataset
from hcss_dataset.score_command import score_command
from hcss_dataset.scoring import Detection, of_mask, read_detections, score
from sets import keys


def target(row, column, scr=5.0, snr=10.0):
    return {"centroid": [row, column], "scr": [scr], "snr": [snr], "peak": [1.0]}


def frame(key, *targets, size=64):
    return {"key": key, "rows": size, "columns": size, "targets": list(targets)}


def test_a_false_alarm_as_large_as_a_hit_counts():
    """Copied scorers drop each false alarm whose area is that of a matched target: here they would count none."""
    mask = np.zeros((64, 64), dtype=np.uint8)
    for number in range(21):
        row, column = 3 + 8 * (number // 7), 3 + 8 * (number % 7)
        mask[row : row + 2, column : column + 2] = 255
    detections = {"f0": of_mask(mask)}
    assert len(detections["f0"]) == 21
    result = score([frame("f0", target(4.0, 4.0))], detections).at_threshold(-math.inf)
    assert (result["found"], result["false_alarms"], result["false_pixels"]) == (1, 20, 80)
    assert result["false_pixel_share"] == 80 / 64**2


def test_a_target_is_found_once():
    near = [Detection(10.0, 10.0, 0.9), Detection(10.5, 10.0, 0.8), Detection(11.0, 10.0, 0.7)]
    result = score([frame("f0", target(10.0, 10.0))], {"f0": near})
    assert result.hit.tolist() == [0, -1, -1]
    found = result.at_threshold(0.8)
    assert (found["found"], found["false_alarms"], found["precision"]) == (1, 1, 0.5)


def test_a_detection_finds_one_target():
    targets = target(10.0, 10.0), target(11.0, 10.0)
    result = score([frame("f0", *targets)], {"f0": [Detection(10.4, 10.0, 1.0)]}).at_threshold(0.0)
    assert (result["found"], result["targets"], result["detection_rate"]) == (1, 2, 0.5)


def test_matches_are_within_the_radius_and_the_frame():
    frames = [frame("f0", target(10.0, 10.0)), frame("f1", target(40.0, 40.0))]
    detections = {"f0": [Detection(40.0, 40.0, 1.0), Detection(10.0, 13.0, 0.9)], "f1": [Detection(40.0, 43.1, 0.8)]}
    assert score(frames, detections, radius=3.0).hit.tolist() == [-1, 0, -1]
    assert score(frames, detections, radius=3.2).hit.tolist() == [-1, 0, 1]


def test_hidden_targets_do_not_count_and_neither_do_their_detections():
    frames = [frame("f0", target(10.0, 10.0, snr=0.2), target(30.0, 30.0))]
    result = score(frames, {"f0": [Detection(10.0, 10.0, 1.0), Detection(30.0, 30.0, 0.5)]})
    measures = result.at_threshold(0.0)
    assert (measures["targets"], measures["found"], measures["false_alarms"], result.ignored) == (1, 1, 0, 1)


def test_the_curve_is_counted_by_hand():
    frames = [frame("f0", target(10.0, 10.0), size=10), frame("f1", target(5.0, 5.0), size=10)]
    detections = {
        "f0": [Detection(10.0, 10.0, 0.9), Detection(1.0, 1.0, 0.7), Detection(2.0, 8.0, 0.4)],
        "f1": [Detection(1.0, 1.0, 0.8), Detection(5.0, 5.0, 0.7)],
    }
    curve = score(frames, detections).curve()
    assert curve["score"].tolist() == [0.9, 0.8, 0.7, 0.4]
    assert curve["detection_rate"].tolist() == [0.5, 0.5, 1.0, 1.0]
    assert curve["false_alarms_per_frame"].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert curve["false_alarms_per_pixel"].tolist() == [0.0, 1 / 200, 2 / 200, 3 / 200]
    result = score(frames, detections)
    assert result.threshold_at(0.006) == 0.8
    assert result.threshold_at(0.01) == 0.7
    assert result.threshold_at(1.0) == 0.4


def test_no_threshold_is_low_enough_for_a_best_detection_that_is_false():
    result = score([frame("f0", target(10.0, 10.0))], {"f0": [Detection(40.0, 40.0, 1.0)]})
    assert result.threshold_at(1e-6) == math.inf
    assert result.at_threshold(math.inf)["found"] == 0


def test_classes_of_scr_have_their_targets():
    targets = [target(10.0 * n, 10.0, scr) for n, scr in enumerate((0.5, 1.0, 3.0, 3.9, 20.0), start=1)]
    detections = {"f0": [Detection(20.0, 10.0, 1.0), Detection(40.0, 10.0, 0.9), Detection(50.0, 10.0, 0.1)]}
    classes = score([frame("f0", *targets)], detections).by_scr(0.5)
    assert [(each["targets"], each["found"]) for each in classes] == [(1, 0), (1, 1), (2, 1), (0, 0), (0, 0), (1, 0)]


def test_frames_without_detections_count():
    result = score([frame("f0"), frame("f1", target(3.0, 3.0))], {}).at_threshold(-math.inf)
    assert (result["targets"], result["found"], result["false_alarms"], result["false_alarms_per_frame"]) == (
        1,
        0,
        0,
        0,
    )


def test_detections_are_read_from_tables_boxes_and_masks(tmp_path):
    (tmp_path / "found.csv").write_text("key, row, column, score, pixels\nf00000003, 4.5, 6.0, 0.25, 4\n")
    boxes = [{"image_id": 3, "category_id": 1, "bbox": [5.0, 3.5, 2.0, 2.0], "score": 0.25}]
    (tmp_path / "found.json").write_text(json.dumps(boxes))
    (tmp_path / "masks").mkdir()
    mask = np.zeros((9, 9), dtype=np.uint8)
    mask[3:6, 5:7] = 7
    np.save(tmp_path / "masks" / "f00000003.npy", mask)
    assert read_detections(tmp_path / "found.csv") == {"f00000003": [Detection(4.5, 6.0, 0.25, 4)]}
    assert read_detections(tmp_path / "found.json") == {"f00000003": [Detection(4.5, 6.0, 0.25, 1)]}
    assert read_detections(tmp_path / "masks") == {"f00000003": [Detection(4.5, 6.0, 7.0, 6)]}


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "key,row,score\nf0,1,2\n", "column 'column' is missing"),
        ("a.csv", "key,row,column,score\nf0,1,2,high\n", "line 2: score = 'high'"),
        ("a.json", "{}", "a list of results"),
        ("a.json", '[{"image_id": 1}]', "result 0"),
    ],
)
def test_wrong_detections_are_named(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(DatasetError, match=words):
        read_detections(tmp_path / name)


def test_detections_in_no_frame_are_refused():
    with pytest.raises(DatasetError, match="frame 'f9'"):
        score([frame("f0")], {"f9": [Detection(1.0, 1.0, 1.0)]})


@pytest.mark.parametrize("name", BASELINES)
@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["bright", "dark"])
def test_baselines_find_a_point_at_its_place(name, sign):
    random, y, x = np.random.default_rng(3), *np.indices((64, 64))
    for row, column in ((20.4, 33.8), (50.2, 9.6)):
        spot = np.exp(-0.5 * ((y + 0.5 - row) ** 2 + (x + 0.5 - column) ** 2) / 0.8**2)
        first = detect(name, 300.0 + random.normal(0.0, 0.05, (64, 64)) + sign * spot)[0]
        assert np.hypot(first.row - row, first.column - column) < 0.8


def test_the_matched_filter_states_the_ratio_of_a_point_in_white_noise():
    """In noise of one variance its output is the signal-to-noise ratio of the spot: contrast x norm / sigma."""
    random = np.random.default_rng(8)
    at = np.arange(5) - 2
    spot = np.exp(-0.5 * (at[:, None] ** 2 + at**2) / 0.8**2)
    norm = np.linalg.norm(spot - spot.mean())
    found = []
    for _ in range(20):
        image = random.normal(0.0, 1.0, (96, 96))
        image[46:51, 46:51] += 30.0 * spot
        found.append(BASELINES["matched-filter"](image)[48, 48])
    # the target itself is in the covariance, which lowers what is found
    assert 0.6 * 30.0 * norm < np.mean(found) < 1.05 * 30.0 * norm


def test_the_command_scores_a_baseline_and_its_detections_alike(tmp_path):
    given = keys({"clouds": None, "frames.count": 1, "image.rows": 64, "image.columns": 64})
    given["targets"]["strength"] = {"scr": 40.0}
    make_dataset(given, tmp_path / "set", 8)
    arguments = ["--baseline", "log", str(tmp_path / "set"), "-o", str(tmp_path / "log.csv")]
    first = CliRunner().invoke(score_command, [*arguments, "--json", "--curve", str(tmp_path / "curve.csv")])
    assert first.exit_code == 0, first.output
    answer = json.loads(first.output.splitlines()[-1])
    assert answer["targets"] > 3
    assert answer["points"][-1]["detection_rate"] == 1.0
    assert answer["most_detections_in_a_frame"] == 100
    told = CliRunner().invoke(score_command, ["--baseline", "log", str(tmp_path / "set")]).output
    assert "no frame has more than 100 detections" in told
    again = CliRunner().invoke(score_command, [str(tmp_path / "log.csv"), str(tmp_path / "set"), "--json"])
    assert json.loads(again.output.splitlines()[-1])["points"] == answer["points"]
    with (tmp_path / "curve.csv").open() as file:
        rates = [float(row["detection_rate"]) for row in csv.DictReader(file)]
    assert rates == sorted(rates)
    assert rates[-1] == 1.0
    refused = CliRunner().invoke(score_command, [str(tmp_path / "set")])
    assert "allowed: DETECTIONS and DATASET" in refused.output
