"""All features of patches that the classifiers see."""

from __future__ import annotations

import numpy as np

from hcss_evaluate.realism.contours import contour_features
from hcss_evaluate.realism.gradients import gradient_features
from hcss_evaluate.realism.increments import increment_features
from hcss_evaluate.realism.moments import histogram_features
from hcss_evaluate.realism.scales import autocorrelation_features, band_features
from hcss_evaluate.realism.spectrum import spectral_features
from hcss_twin.providers import Array

_TOPICS = (
    spectral_features,
    gradient_features,
    increment_features,
    histogram_features,
    contour_features,
    band_features,
    autocorrelation_features,
)
_AT_ONCE = 128


def all_features(patches: Array) -> tuple[list[str], Array]:
    """Return names and values (P, F) of the features of patches (P, n, n)."""
    parts = []
    for first in range(0, len(patches), _AT_ONCE):
        part = patches[first : first + _AT_ONCE]
        found = {name: values for topic in _TOPICS for name, values in topic(part).items()}
        parts.append(np.stack(list(found.values()), axis=1))
    return list(found), np.concatenate(parts)
