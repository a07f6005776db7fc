"""A cloud image as the morphology sees it: clear pixels 0, cloudy ones 1 to 255, linear in thickness.

Measured and simulated images come through the same layer, one that is 1 to 255 thick, so that both
have the same definition of a grey level: that of eq 7 of the HCSS paper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.clouds.fractal.generator import FractalClouds
from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.evaluation.morphology import Morphology, morphology
from hcss_twin.providers import CloudInputs, CloudLayer, Grid, Microphysics, Motion

# Nothing here looks at the particles, but a layer has some.
_NO_MATTER = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (0.1, 50.0))
LEVELS = (1.0, 255.0)
"""Least and greatest grey level of a cloudy pixel."""

STILL = Motion(0.0, (0.0, 0.0), math.inf, 0.0)


@dataclass(frozen=True)
class CloudImage:
    """One image.

    Attributes
    ----------
    level : ndarray of float32 (rows, columns)
        0 where clear, 1 to 255 where cloudy, not rounded; rows run northward, columns eastward.
    pixel_size_m : float
        Side of a pixel.
    """

    level: NDArray[np.float32]
    pixel_size_m: float

    @property
    def cloudy(self) -> NDArray[np.bool_]:
        """Mask of the cloudy pixels."""
        return self.level > 0.0

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return float(np.count_nonzero(self.level)) / self.level.size

    @property
    def mean_level(self) -> float:
        """Mean grey level of the cloudy pixels."""
        return float(np.sum(self.level, dtype=np.float64)) / max(1, int(np.count_nonzero(self.level)))

    def morphology(self) -> Morphology:
        """Measure it.

        Raises
        ------
        ImageError
            If there is too little cloud, or it does not vary.
        """
        return morphology(self.level, self.cloudy)


def grey_inputs(
    coverage: float, rows: int, columns: int, pixel_size_m: float, seed: int = 0, base: Path | None = None
) -> CloudInputs:
    """Return the inputs with which a cloud generator makes grey levels instead of metres.

    ``base`` is the folder of relative paths, the working directory by default.
    """
    layer = CloudLayer("grey levels", 0.0, LEVELS[1], "base", LEVELS[0], coverage, None, _NO_MATTER)
    return CloudInputs(layer, Grid(rows, columns, pixel_size_m), STILL, seed, Catalog(base=base))


def simulate_image(parameters: FractalParameters, coverage: float, like: CloudImage, seed: int) -> CloudImage:
    """Simulate one frame of the size and the pixels of another image.

    Raises
    ------
    ScenarioError
        If ``parameters`` leave something open.
    """
    rows, columns = like.level.shape
    generator = FractalClouds(grey_inputs(coverage, rows, columns, like.pixel_size_m, seed), parameters)
    return CloudImage(generator.thickness_m(0.0, slice(0, rows), slice(0, columns)), like.pixel_size_m)
