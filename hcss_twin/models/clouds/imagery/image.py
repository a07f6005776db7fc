"""One plane of a satellite image in memory, from any file format."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.clouds.imagery.cloudiness import Cloudiness
from hcss_twin.models.clouds.imagery.examination import (
    KELVIN_LIMITS,
    MOST_FILLS,
    closest_reading,
    doubted_kelvin,
    fill_values,
    in_kelvin,
    questions,
    without_border,
)
from hcss_twin.providers import Grid

__all__ = ["SatelliteImage"]

CLEAR_PERCENTILE, COLD_K = 99.0, 2.0
"""Of the brightness temperature of an image, that of the clear sky; how much colder a pixel is certainly cloudy."""

# Relative difference of pixel sizes that is accepted as equal.
_SAME_SIZE = 0.01


@dataclass(frozen=True)
class PlanckCoefficients:
    """Coefficients of T = [fk2 / ln(fk1 / L + 1) - bc1] / bc2, L in mW m-2 sr-1 (cm-1)-1, T in K.

    GOES-R Product Definition and Users' Guide, volume 3, emissive bands of level 1b.
    """

    fk1: float
    fk2: float
    bc1: float
    bc2: float

    def kelvin(self, radiance: Array) -> Array:
        """Return brightness temperatures; NaN where the radiance is missing or not positive."""
        known = radiance > 0.0
        safe = np.where(known, radiance, 1.0)
        temperature = (self.fk2 / np.log(self.fk1 / safe + 1.0) - self.bc1) / self.bc2
        return np.where(known, temperature, np.nan)


def same_size(native_m: float, grid: Grid) -> bool:
    """Whether the pixel sizes of an image and of the scene agree to 1 %."""
    return abs(grid.pixel_size_m - native_m) <= _SAME_SIZE * native_m


def size_notes(size_m: float | None, is_nominal: bool, grid: Grid) -> list[str]:
    """Describe the image's pixel size, and how it differs from the scene's."""
    notes = []
    if size_m is None:
        return [f"The image gives no pixel size; {grid.pixel_size_m:g} m is the scenario's."]
    if is_nominal:
        notes.append(
            f"The image's pixel size, {size_m:.5g} m, is nominal: that below the geostationary satellite; "
            "pixels elsewhere are larger."
        )
    if not same_size(size_m, grid):
        notes.append(f"Pixels of {size_m:.5g} m are taken for pixels of {grid.pixel_size_m:g} m.")
    return notes


@dataclass(frozen=True)
class SatelliteImage:
    """One plane of an image with its metadata.

    Attributes
    ----------
    values : ndarray of float64 (rows, columns)
        As stored, in physical units if the file gives them; NaN where missing.
    pixel_size_m : float or None
        Side of a pixel on the ground; None where the file does not give it.
    bright_is_cloud : bool
        Whether cloud has the larger values.
    units, long_name : str
        Of the values; empty if the file does not give them.
    source : str
        Name of the file.
    pixel_size_is_nominal : bool
        True for a geostationary image: its pixel size applies at the sub-satellite point; pixels elsewhere are larger.
    north_first, east_first : bool
        Whether the first row is the northernmost, and the first column the easternmost. Files without coordinates are
        assumed to have north in the first row and west in the first column.
    pixel_size_note : str
        Why the grid of the file gives no pixel size; else empty.
    variable, band, date, rights : str
        Name of the plane in the file, spectral band, time of observation and terms of use, as stated in the file;
        otherwise empty.
    planck : PlanckCoefficients or None
        Coefficients of the brightness temperature of radiances, if the file has them.
    notes : tuple of str
        What the user should know of pixels that show nothing although the file does not say so.
    WINDOW_UM : (float, float)
        Wavelengths at which the air is transparent enough for the inversion of brightness temperature at 10.8 um.
    CloudIs, Cloudy
        Whether cloud has the larger values, and what is cloud: threshold, relative grey level and thickness.
    """

    WINDOW_UM: ClassVar = (10.0, 12.6)

    CloudIs = Literal["auto", "bright", "dark"]
    Cloudy = Cloudiness

    class SeveralImagesError(CatalogError):
        """A file has several images, and none of them is chosen.

        Parameters
        ----------
        path : Path
            The file.
        planes : iterable of str
            Names of the images.
        hint : str
            What is known of them.
        option : str
            What chooses one of them.
        """

        def __init__(self, path: Path, planes: Iterable[str], hint: str = "", option: str = "variable") -> None:
            self._parts = path, tuple(planes), hint
            listed = ", ".join(sorted(planes))
            super().__init__(f"{path}: several images; set {option} to one of: {listed}{f'; {hint}' if hint else ''}")

        def chosen_with(self, option: str) -> SatelliteImage.SeveralImagesError:
            """Return the same error of a command whose option chooses the image."""
            return SatelliteImage.SeveralImagesError(*self._parts, option)

    values: NDArray[np.float64]
    pixel_size_m: float | None
    bright_is_cloud: bool
    units: str
    long_name: str
    source: str
    pixel_size_is_nominal: bool = False
    north_first: bool = True
    east_first: bool = False
    pixel_size_note: str = ""
    variable: str = ""
    band: str = ""
    date: str = ""
    rights: str = ""
    planck: PlanckCoefficients | None = None
    notes: tuple[str, ...] = ()

    @property
    def is_temperature(self) -> bool:
        """Whether the values are in kelvin."""
        return self.units == "K"

    @property
    def wavelength_um(self) -> float | None:
        """Wavelength of the band, if the file states it."""
        stated = re.search(r"([\d.]+) um", self.band)
        return float(stated[1]) if stated else None

    @property
    def north_and_east_last(self) -> Array:
        """The values (rows, columns), rows northward and columns eastward."""
        return self.values[:: -1 if self.north_first else 1, :: -1 if self.east_first else 1]

    @property
    def has_values_in_cloud_only(self) -> bool:
        """Whether the image shows only cloud tops: "cloud top" in its name, and missing pixels elsewhere."""
        name = f"{self.variable} {self.long_name}".lower().replace("_", " ")
        return "cloud top" in name and bool(np.isnan(self.values).any())

    def lost_cloud(self, level: Array, cloudy: NDArray[np.bool_], cloud_is: CloudIs) -> tuple[str, ...]:
        """Return a note on cold pixels that are not ``cloudy``, for images of brightness temperature; else none."""
        if not self.is_temperature or self.cloud_is_bright(cloud_is):
            return ()
        clear = float(np.nanpercentile(self.values, CLEAR_PERCENTILE))
        cold = -level < clear - COLD_K
        lost = np.count_nonzero(cold & ~cloudy) / max(int(np.count_nonzero(cold)), 1)
        if lost < 5e-5:
            return ()
        return (
            f"{lost:.2%} of the pixels that are {COLD_K:g} K colder than clear sky ({clear:.5g} K) are left out as "
            "clear; the method 'temperature' of the generator imagery keeps them.",
        )

    def cloud_is_bright(self, cloud_is: CloudIs) -> bool:
        """Whether large values are cloud, according to the user or else the quantity."""
        return self.bright_is_cloud if cloud_is == "auto" else cloud_is == "bright"

    def level(self, cloud_is: CloudIs) -> Array:
        """Return the cloudiness level (rows, columns), rows northward and columns eastward."""
        values = self.north_and_east_last
        return values if self.cloud_is_bright(cloud_is) else -values

    def described(self, cloud_is: CloudIs) -> tuple[str, ...]:
        """Return sentences on what the image is taken for, what is doubtful about it, and which pixels it lacks."""
        bright, name = self.cloud_is_bright(cloud_is), f"{self.variable} {self.long_name}".casefold()
        if self.is_temperature:
            quantity = "temperature in kelvin" if "top" in name else "brightness temperature in kelvin"
        elif "sr-1" in self.units or "radiance" in name:
            quantity = f"radiance in {self.units or 'an unknown unit'}"
        elif "reflect" in name or "albedo" in name:
            quantity = "reflectance" if self.units in ("", "1") else f"reflectance in {self.units}"
        elif self.units in ("", "1"):
            quantity = "grey values"
        else:
            quantity = f"{self.long_name.replace('_', ' ')} in {self.units}"
        sense = "bright is cloud" if bright else "cold is cloud" if self.is_temperature else "dark is cloud"
        asked = questions(self.values, self.units, bright, stated=cloud_is != "auto")
        return (f"The image is taken for {quantity}; {sense}.", *asked, *self.notes)

    def size_notes(self, grid: Grid) -> list[str]:
        """Describe the pixel size, and how it differs from that of a scene."""
        return size_notes(self.pixel_size_m, self.pixel_size_is_nominal, grid)

    @classmethod
    def of_kelvin(cls, values: Array) -> SatelliteImage:
        """Return values without a stated unit as the image of temperature for which they are taken."""
        return cls(values, None, False, "K", "", "")

    def closest_reading(self) -> str:
        """Return, as the end of a message, the other unit in which the values would be temperatures, if any."""
        return closest_reading(self.values, self.units)

    def in_kelvin(self) -> SatelliteImage:
        """Return an image of temperature in K, whose cold is cloud, if its unit is one of temperature."""
        kelvin = in_kelvin(self.values, self.units)
        return self if kelvin is None else replace(self, values=kelvin, units="K", bright_is_cloud=False)

    def examined(self, path: Path) -> SatelliteImage:
        """Return the image without the pixels that show nothing: NaN, with notes that name them.

        Values may be NaN where the file states that there is no value. Temperatures are converted to K.

        Parameters
        ----------
        path : Path
            The file, for messages.

        Raises
        ------
        CatalogError
            If the image has a side of one pixel, no two different values, or temperatures that are none.
        """
        rows, columns = self.values.shape
        if min(rows, columns) < 2:
            raise CatalogError(f"{path}: an image of {rows} x {columns} pixels; allowed: 2 or more rows and columns")
        notes = []
        image = self.in_kelvin()
        values = np.where(np.isfinite(image.values), image.values, np.nan)
        infinite = np.count_nonzero(np.isinf(image.values))
        if infinite:
            notes.append(f"Infinite values ({infinite} pixels) are taken for missing.")
        _require_contrast(path, values)
        while fills := self._impossible(path, values) if image.is_temperature else fill_values(values, image.units):
            counts = [int(np.count_nonzero(values == value)) for value in fills]
            values[np.isin(values, fills)] = np.nan
            rest = f"{np.nanmin(values):.5g} to {np.nanmax(values):.5g}"
            notes += [
                f"{value:g} ({count} pixels) is far from the rest, {rest}: taken for missing."
                for value, count in zip(fills, counts, strict=True)
            ]
        notes += without_border(values)
        _require_contrast(path, values)
        if image.is_temperature:
            doubt = doubted_kelvin(values, self.values, self.units)
            if doubt:
                raise CatalogError(f"{path}: {self.variable or self.long_name} (stated unit: {self.units}): {doubt}")
        return replace(image, values=values, notes=(*image.notes, *notes))

    def _impossible(self, path: Path, kelvin: Array) -> list[float]:
        """Return the values in K, at most a few, that are no brightness temperatures; raises if there are many."""
        low, high = KELVIN_LIMITS
        wrong = kelvin[(kelvin < low) | (kelvin > high)]
        different = np.unique(wrong)
        if different.size > 2 * MOST_FILLS or 2 * wrong.size > np.count_nonzero(np.isfinite(kelvin)):
            raise CatalogError(
                f"{path}: {wrong.size} pixels of {self.variable or self.long_name} have values from {wrong.min():.5g} "
                f"to {wrong.max():.5g} K (stated unit: {self.units}); allowed: brightness temperatures "
                f"of {low:g} to {high:g} K{self.closest_reading() or '; are scale_factor and add_offset missing?'}"
            )
        return [float(value) for value in different]


def _require_contrast(path: Path, values: Array) -> None:
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        raise CatalogError(f"{path}: all {values.size} pixels are missing")
    if finite.min() == finite.max():
        raise CatalogError(f"{path}: all pixels have the value {finite[0]:g}; clouds need a contrast")
