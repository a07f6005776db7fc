"""Classifiers that try to tell simulated from real patches, and how well they do (AUC)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin import HcssError, ImageError
from hcss_twin.providers import Array

Classifier = Literal["forest", "boosting", "linear"]
_FOLDS = 5


def require_scikit_learn() -> None:
    """Raise HcssError if scikit-learn, an optional package, is missing."""
    try:
        import sklearn  # noqa: F401
    except ImportError as error:
        raise HcssError(
            "the realism test needs the package scikit-learn; install it with: pip install 'hcss-evaluate[realism]'"
        ) from error


def _classifier(name: Classifier, seed: int) -> Any:
    from sklearn.ensemble import HistGradientBoostingClassifier, RandomForestClassifier
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    if name == "forest":
        return RandomForestClassifier(200, min_samples_leaf=3, class_weight="balanced", random_state=seed)
    if name == "linear":
        return make_pipeline(StandardScaler(), LogisticRegression(C=0.1, max_iter=1000))
    # Splits choose among some features only: where one feature tells everything, the others are learnt, too.
    return HistGradientBoostingClassifier(max_features=0.3, random_state=seed)


def out_of_fold(
    features: Array, simulated: NDArray[np.bool_], scene: NDArray[np.int64], name: Classifier, seed: int
) -> Array:
    """Return the probability (P,) of each patch to be simulated, from a classifier that never saw its scene.

    All patches of a scene, real and simulated, are in the same one of five folds (fewer with fewer scenes).

    Parameters
    ----------
    features : ndarray (P, F)
    simulated : ndarray (P,)
    scene : ndarray (P,)
    name : {"forest", "boosting", "linear"}
        Random forest of 200 trees with 3 patches per leaf and equal weight of both sides, gradient boosting with
        histograms, or logistic regression of features in units of their standard deviation.
    seed : int
        Of the folds and the classifier.

    Raises
    ------
    ImageError
        If a side has patches of fewer than two scenes, so that a fold would leave none to learn from.
    """
    from sklearn.model_selection import StratifiedGroupKFold

    scenes = [len(np.unique(scene[simulated == side])) for side in (False, True)]
    needed = "allowed: 2 or more, better 10, so that scenes can be left out"
    for side, count in zip(("real", "simulated"), scenes, strict=True):
        if count < 2:
            raise ImageError(f"{side} scenes with cloud: {count}, {needed}")
    folds = StratifiedGroupKFold(min(_FOLDS, *scenes), shuffle=True, random_state=seed)
    probability = np.empty(len(features))
    for train, test in folds.split(features, simulated, scene):
        if len(np.unique(simulated[train])) < 2:
            raise ImageError(
                f"scenes with cloud: {scenes[0]} real and {scenes[1]} simulated of very different size, {needed}"
            )
        rows = train if name == "forest" else _balanced(train, simulated)
        model = _classifier(name, seed).fit(features[rows], simulated[rows])
        probability[test] = model.predict_proba(features[test])[:, -1]
    return probability


def _balanced(train: NDArray[np.intp], simulated: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return patches to learn from, those of the smaller side repeated until both sides have about as many.

    Otherwise probabilities of boosting depend on how many patches of each side the other folds have, and do not
    compare between folds.
    """
    sides = sorted((train[~simulated[train]], train[simulated[train]]), key=len)
    return np.concatenate((np.tile(sides[0], round(len(sides[1]) / len(sides[0]))), sides[1]))


def auc(score: Array, simulated: NDArray[np.bool_], weight: Array | None = None) -> float:
    """Return the probability that a simulated patch has a larger score than a real one (ties count half)."""
    distinct, rank = np.unique(score, return_inverse=True)
    heavy = np.ones(len(score)) if weight is None else weight
    yes, no = (np.bincount(rank[side], heavy[side], len(distinct)) for side in (simulated, ~simulated))
    return float(np.sum(yes * (np.cumsum(no) - no / 2.0)) / (yes.sum() * no.sum()))


def auc_interval(
    score: Array, simulated: NDArray[np.bool_], scene: NDArray[np.int64], *, resamples: int, seed: int
) -> tuple[float, float]:
    """Return the 95 % confidence interval of the AUC, by bootstrap over scenes.

    Scenes, not patches, are drawn with replacement, because patches of one scene are alike. Scenes that have both
    sides, only real and only simulated patches are drawn apart, so that both sides are always present.
    """
    rng = np.random.default_rng(seed)
    names, index = np.unique(scene, return_inverse=True)
    kind = np.zeros(len(names), dtype=np.intp)
    np.bitwise_or.at(kind, index, np.where(simulated, 2, 1))
    found = []
    for _ in range(resamples):
        weight = np.zeros(len(names))
        for group in np.unique(kind):
            members = np.flatnonzero(kind == group)
            weight[members] = rng.multinomial(len(members), np.full(len(members), 1.0 / len(members)))
        drawn = weight[index]
        found.append(auc(score, simulated, drawn))
    low, high = np.quantile(found, (0.025, 0.975))
    return float(low), float(high)
