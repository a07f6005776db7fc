"""What of a file is compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from hcss_twin.clouds.imagery.cloudiness import CloudIs
from hcss_twin.errors import ImageOptionError

Method = Literal["auto", "otsu", "local", "coverage", "valid", "truth"]


@dataclass(frozen=True)
class EvaluationChoice:
    """Which part of an image or a cube is compared, and what in it is cloud.

    Attributes
    ----------
    variable : str or None
        Variable of a NetCDF or ``.npz`` file or of a cube, or number of a GeoTIFF's band.
    band : str or None
        Name of a cube's band.
    frames : tuple of int
        Numbers of a cube's frames from 0; none: all.
    method : {"auto", "otsu", "local", "coverage", "valid", "truth"}
        How cloudy pixels are found. ``valid`` takes every pixel that has a value, ``truth`` a cube's own cloud mask;
        ``auto`` is ``valid`` for cloud-top products, ``truth`` for a cube's variables of clouds, ``otsu`` for all else.
    cloud_is : {"auto", "bright", "dark"}
        Which values are cloud.
    coverage : float or None
        For method ``coverage``: cloudy fraction.
    window_pixels : int or None
        For method ``local``: side of the surroundings.
    pixel_size_m : float or None
        Side of a pixel, in place of what the file tells.
    """

    variable: str | None = None
    band: str | None = None
    frames: tuple[int, ...] = ()
    method: Method = "auto"
    cloud_is: CloudIs = "auto"
    coverage: float | None = None
    window_pixels: int | None = None
    pixel_size_m: float | None = None

    def check(self) -> None:
        """Refuse options that contradict each other: none is ignored.

        Raises
        ------
        ImageOptionError
            Naming the option.
        """
        if (self.coverage is None) is (self.method == "coverage"):
            raise ImageOptionError("coverage: goes with the method 'coverage', and only with it")
        if self.coverage is not None and not 0.0 < self.coverage <= 1.0:
            raise ImageOptionError(f"coverage: {self.coverage} given, allowed: greater than 0, up to 1")
        if self.window_pixels is not None and self.method != "local":
            raise ImageOptionError("window_pixels (--window): goes with the method 'local', and only with it")
        if self.pixel_size_m is not None and not self.pixel_size_m > 0.0:
            raise ImageOptionError(f"pixel_size: {self.pixel_size_m} m given, allowed: greater than 0")
