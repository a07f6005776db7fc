"""The realism test tells different processes apart, and not one process from itself."""

import json
import sys

import numpy as np
import pytest
from hcss_evaluate.realism import compare
from hcss_evaluate.realism.classifiers import auc
from random_fields import power_law

from hcss_twin import HcssError, ImageError

pytest.importorskip("sklearn", reason="scikit-learn is optional: pip install 'hcss-evaluate[realism]'")
QUICK = {"resamples": 100, "size": 32, "blur_pixels": 0.0, "copies": 0}


def fields(seed, slope, count=8):
    rng = np.random.default_rng(seed)
    return np.stack([power_law(rng, slope, 128) for _ in range(count)])


ALL = "forest", "boosting", "linear"


def test_two_slopes_are_told_apart_by_their_spectrum():
    found = compare(fields(1, -2.5), fields(2, -3.3), classifiers=ALL, **QUICK)
    assert min(score.auc for score in found.scores) > 0.97
    assert {(score.classifier, score.scale) for score in found.scores} == {
        (classifier, scale) for classifier in ALL for scale in ("z-scored", "kelvin")
    }
    assert abs(found.features[0].auc - 0.5) > 0.45
    slope = next(feature for feature in found.features if feature.name == "spectral slope")
    assert slope.simulated < slope.real - 0.5
    assert slope.auc < 0.1
    json.dumps(found.as_dict(), allow_nan=False)


def test_few_scenes_suffice_where_single_features_tell_everything():
    found = compare(fields(1, -2.0), fields(2, -3.6, 2), classifiers=["boosting"], scales=["z-scored"], **QUICK)
    assert found.scores[0].auc > 0.99


def test_two_halves_of_one_process_are_not_told_apart():
    both = fields(3, -3.0, 12)
    scenes = range(12)
    found = compare(both[:, :64], both[:, 64:], scenes, scenes, classifiers=ALL, scales=["z-scored"], **QUICK)
    for score in found.scores:
        assert score.low < 0.5 < score.high
        assert abs(score.auc - 0.5) < 0.12
    assert found.common_scenes == 12


def test_the_same_seed_gives_the_same_numbers():
    given = (fields(4, -3.0, 4), fields(5, -2.8, 4))
    first, second, other = (
        compare(*given, seed=seed, classifiers=["boosting"], scales=["kelvin"], **QUICK) for seed in (6, 6, 7)
    )
    assert first == second != other


def test_auc_is_the_share_of_pairs_in_order():
    rng = np.random.default_rng(8)
    score, simulated = rng.integers(0, 9, 60).astype(float), rng.random(60) < 0.4
    weight = rng.integers(0, 4, 60)
    pairs = score[simulated][:, None] - score[~simulated]
    assert auc(score, simulated) == pytest.approx(np.mean((pairs > 0) + 0.5 * (pairs == 0)))
    repeated = np.repeat(np.arange(60), weight)
    assert auc(score, simulated, weight) == pytest.approx(auc(score[repeated], simulated[repeated]))


@pytest.mark.parametrize(
    ("real", "message"),
    [
        (np.full((2, 128, 128), 290.0), "none of 32 patches has cloud"),
        (np.ones((2, 128, 128)), "allowed: brightness temperature"),
        (np.full((2, 20, 128), 290.0), "allowed: 32 x 32 pixels or more"),
        (fields(9, -3.0, 1), "real scenes with cloud: 1"),
    ],
)
def test_unusable_images_are_named(real, message):
    with pytest.raises(ImageError, match=message):
        compare(real, fields(9, -3.0, 2), **QUICK)


def test_a_wrong_number_of_scenes_is_named():
    with pytest.raises(ImageError, match=r"simulated_scene: shape \(3,\), allowed: \(2,\)"):
        compare(fields(9, -3.0, 2), fields(9, -3.0, 2), [0, 1], [0, 1, 2], **QUICK)


def test_missing_scikit_learn_is_named_with_its_cure(monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(HcssError, match=r"pip install 'hcss-evaluate\[realism\]'"):
        compare(fields(9, -3.0, 2), fields(9, -3.0, 2))
