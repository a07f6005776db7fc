"""What a fit knows of an image, and the same of a simulated one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from hcss_twin.clouds.coverage import highest_values
from hcss_twin.clouds.fractal.generator import FractalClouds
from hcss_twin.clouds.fractal.parameters import FractalParameters
from hcss_twin.errors import ImageError
from hcss_twin.evaluation.checks import SMALLEST_SIDE
from hcss_twin.matching.cloud_image import CloudImage, grey_inputs
from hcss_twin.matching.structure import octave_lags
from hcss_twin.uncertainty.normal_scores import field_scores, image_scores, score_variogram

Array = NDArray[np.float64]

# Fewer pixels of one kind leave a variogram of single clouds, or of single gaps.
_FEWEST_PIXELS = 100


@dataclass(frozen=True)
class ImageData:
    """Measured statistics of one image.

    Attributes
    ----------
    rows, columns : int
        Size.
    pixel_size_m : float
        Side of a pixel.
    cloudy : int
        Cloudy pixels.
    lags : ndarray of int64 (M,)
        Pixels.
    variogram : ndarray (2 M,)
        Semivariances of normal scores along x, then along y.
    """

    rows: int
    columns: int
    pixel_size_m: float
    cloudy: int
    lags: NDArray[np.int64]
    variogram: Array

    @classmethod
    def of(cls, image: CloudImage, smallest_lag: int = 1) -> ImageData:
        """Measure an image.

        Raises
        ------
        ImageError
            If the image is too small, has too few cloudy or clear pixels, or does not vary.
        """
        level = image.level
        if level.ndim != 2 or min(level.shape) < SMALLEST_SIDE:
            raise ImageError(
                f"image: {' x '.join(map(str, level.shape))} pixels, allowed: {SMALLEST_SIDE} or more along each axis"
            )
        if not np.all(np.isfinite(level)):
            raise ImageError("image: a pixel is not finite, allowed: grey levels, 0 where clear")
        cloudy = int(np.count_nonzero(level))
        for count, what in ((cloudy, "cloudy"), (level.size - cloudy, "clear")):
            if count < _FEWEST_PIXELS:
                raise ImageError(
                    f"image: {count} of {level.size} pixels are {what}, allowed: {_FEWEST_PIXELS} or more; another "
                    "part, or another method of finding cloud, may have them"
                )
        lags = [lag for lag in octave_lags(level.shape) if lag >= smallest_lag]
        if len(lags) < 2:
            raise ImageError(
                f"smallest lag: {smallest_lag} pixels, allowed: 1 to {octave_lags(level.shape)[-2]}, with two lags or "
                "more up to a third of the shorter side"
            )
        distances = np.array(lags, dtype=np.int64)
        variogram = score_variogram(image_scores(level), distances)
        rows, columns = level.shape
        return cls(rows, columns, image.pixel_size_m, cloudy, distances, variogram)

    @property
    def coverage(self) -> float:
        """Cloudy part of the pixels."""
        return self.cloudy / (self.rows * self.columns)

    @property
    def threshold(self) -> float:
        """Normal score above which pixels are cloudy."""
        return float(ndtri(1.0 - self.coverage))

    def simulate(self, shape: Array, octaves: tuple[int, int], seed: int) -> tuple[Array, float]:
        """Measure a simulated image of this size, of these lags and of this many cloudy pixels.

        Parameters
        ----------
        shape : ndarray (4,)
            H, gamma, Lx, Ly.
        octaves : (int, int)
            First and last.
        seed : int
            Realisation.

        Returns
        -------
        variogram : ndarray (2 M,)
            As :attr:`variogram`.
        threshold : float
            Of the field V, above which these pixels lie: that of the sky.
        """
        hurst, gamma, cells_x, cells_y = (float(each) for each in shape)
        parameters = FractalParameters(gamma=gamma, H=hurst, L=(cells_x, cells_y), k=octaves)
        inputs = grey_inputs(self.coverage, self.rows, self.columns, self.pixel_size_m, seed)
        field = FractalClouds(inputs, parameters, threads=1).field(
            0.0, slice(0, self.rows), slice(0, self.columns)
        )
        lowest, _ = highest_values(field, self.coverage)
        assert lowest is not None
        scores = field_scores(field, self.cloudy)
        return score_variogram(scores, self.lags), float(lowest)
