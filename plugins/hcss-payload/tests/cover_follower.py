"""A scene that follows images by their mean: the share of the sky that clouds cover."""

import json
from datetime import UTC, datetime

import numpy as np

from hcss_twin import Scenario
from hcss_twin.providers import ImageError


class _Cover:
    def read(self, path):
        try:
            return np.load(path), datetime(2024, 4, 20, tzinfo=UTC)
        except ValueError as error:
            raise ImageError(f"file: '{path}' is no image; allowed: .npy") from error

    def assimilated(self, scenario, image, time):
        if not 0.0 <= np.mean(image) <= 1.0:
            raise ImageError(f"image: a mean of {np.mean(image):g}; allowed: 0 to 1")
        data = json.loads(scenario.to_json())
        data["clouds"]["layers"][0]["coverage"] = float(np.mean(image))
        return Scenario.from_dict(data, base=scenario.base)


cover = _Cover()
