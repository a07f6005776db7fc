"""No leak: nothing but their pixels tells frames with targets from those without.

A classifier sees noise, clipping, file sizes, order, means and deviations of frames in which squares are cut out: round
each target, and in frames without targets at places of targets of other frames.
"""

import copy

import numpy as np
import pytest
from hcss_dataset import Frames
from hcss_dataset.make import make_dataset
from hcss_dataset.png import encoded
from sets import BANDS, keys

linear_model = pytest.importorskip("sklearn.linear_model", reason="scikit-learn is not installed: hcss-dataset[test]")
from sklearn.ensemble import HistGradientBoostingClassifier  # noqa: E402
from sklearn.metrics import roc_auc_score  # noqa: E402
from sklearn.model_selection import StratifiedKFold, cross_val_predict  # noqa: E402
from sklearn.pipeline import make_pipeline  # noqa: E402
from sklearn.preprocessing import StandardScaler  # noqa: E402

FRAMES = 800
HALF = 8
"""Half of the side of a square that is cut out, pixels."""


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    """Frames under more or less cloud, which hides many targets from their SCR: their draws are refused."""
    coverage = {"clouds": {"coverage": {"distribution": "uniform", "from": 0.1, "to": 0.95}}}
    given = keys({"image.rows": 48, "image.columns": 48, "frames.count": 1, "bands": BANDS[1:]}, draw=coverage)
    given["targets"] |= {"count": 1, "empty": 0.5, "altitude": 0.0, "speed": 0.0}
    given["targets"]["strength"] = {"scr": {"distribution": "uniform", "from": 2.0, "to": 8.0}, "intensity_max": 2e4}
    folder = tmp_path_factory.mktemp("leaks")
    made = make_dataset(given, folder, FRAMES)
    assert made.refused > 0.2 * FRAMES  # a sky that is drawn again with its targets would be a leak
    return [
        {
            "image": frame.image[0],
            "clean": frame.clean[0],
            "labels": frame.labels,
            "size": next(at[1] for name, at in frame.labels["images"].items() if name.startswith("clean")),
            "place": frame.labels["number"] % 8,
        }
        for frame in Frames(folder)
    ]


def features(frames):
    """What is known of frames without the pixels of their targets, and whether they have some.

    The size of a file is that of its image's content, to the byte.
    """
    random = np.random.default_rng(0)
    places = [each["place"] for frame in frames for each in frame["labels"]["targets"]]
    rows = []
    for frame in frames:
        own = [each["place"] for each in frame["labels"]["targets"]]
        keep = np.ones(frame["image"].shape, dtype=bool)
        for row, column in own or [places[random.integers(len(places))]]:
            keep[max(int(row) - HALF, 0) : int(row) + HALF + 1, max(int(column) - HALF, 0) : int(column) + HALF + 1] = 0
        image, clean = frame["image"][keep].astype(float), frame["clean"][keep].astype(float)
        noise = image - clean
        shown = np.where(keep, frame["image"], np.uint16(np.median(image)))
        rows.append(
            [
                noise.std(), noise.mean(), np.mean(noise**3), np.mean(noise**4), np.mean(image == 0),
                np.mean(image == frame["labels"]["largest_number"]), image.mean(), clean.std(), np.median(clean),
                clean.min(), clean.max(), len(encoded(shown)), frame["size"] - len(encoded(frame["clean"])),
                frame["place"], frame["labels"]["number"] % 20,
                frame["labels"]["noise"][0], frame["labels"]["table_error"], frame["labels"]["number"],
            ]
        )  # fmt: skip
    return np.array(rows), np.array([bool(frame["labels"]["targets"]) for frame in frames])


def area(frames):
    """Area under the curve of a linear classifier and of trees, on frames that they were not trained on."""
    given, wanted = features(frames)
    folds = StratifiedKFold(5, shuffle=True, random_state=0)
    linear = make_pipeline(StandardScaler(), linear_model.LogisticRegression(C=0.1))
    trees = HistGradientBoostingClassifier(max_iter=60, max_depth=3, learning_rate=0.1, random_state=0)
    return [
        roc_auc_score(wanted, cross_val_predict(each, given, wanted, cv=folds, method="predict_proba")[:, 1])
        for each in (linear, trees)
    ]


@pytest.mark.long
def test_frames_with_targets_are_not_told_from_others_without_their_pixels(frames):
    found = area(frames)
    assert min(found) > 0.45, found
    assert max(found) < 0.55, found


def more_noise(frame):
    noise = np.random.default_rng(frame["labels"]["number"]).normal(0.0, 4.0, frame["image"].shape)
    frame["image"] = (frame["image"] + noise).astype(np.uint16)


def clipped(frame):
    frame["image"][:2, ::7] = frame["labels"]["largest_number"]


def other_order(frame):
    frame["place"] = frame["place"] // 2


def larger_file(frame):
    frame["size"] += 1


def less_cloud(frame):
    frame["clean"] = frame["image"] = (frame["clean"] + 30).astype(np.uint16)


@pytest.mark.long
@pytest.mark.parametrize("leak", [more_noise, clipped, other_order, larger_file, less_cloud])
def test_planted_leaks_are_found(frames, leak):
    changed = copy.deepcopy(frames)
    for frame in changed:
        if frame["labels"]["targets"]:
            leak(frame)
    assert max(area(changed)) > 0.6
