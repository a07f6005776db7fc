"""Spectra of one atmospheric path, from one run of another code."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError

RadianceUnit = Literal["per_cm1", "per_um", "per_nm"]
"""Spectral unit of radiance and irradiance: per cm-1, per micrometre, per nanometre."""


@dataclass(frozen=True)
class PathGeometry:
    """Line of sight of a run.

    Attributes
    ----------
    observer_m : float
        Altitude of the observer (H1).
    end_m : float
        Altitude of the far end (H2).
    angle_deg : float
        Zenith angle of the line of sight at the observer: below 90 upwards, above 90 downwards.
    horizontal : bool
        A path of constant altitude (ITYPE = 1); ``end_m`` is then ignored.
    refracted : bool
        Whether the code refracts rays; False for plane-parallel solvers, whose angle is the same at every level.
    """

    observer_m: float
    end_m: float
    angle_deg: float
    horizontal: bool = False
    refracted: bool = True

    @property
    def kind(self) -> Literal["up", "down", "horizontal", "limb"]:
        """Type of path; ``limb``: through a tangent point, or the angle contradicts the ends."""
        if self.horizontal:
            return "horizontal"
        if self.angle_deg < 90.0 and self.end_m > self.observer_m:
            return "up"
        if self.angle_deg > 90.0 and self.end_m < self.observer_m:
            return "down"
        return "limb"

    @property
    def lower_m(self) -> float:
        """Altitude of the lower end."""
        return min(self.observer_m, self.end_m)

    @property
    def upper_m(self) -> float:
        """Altitude of the upper end."""
        return max(self.observer_m, self.end_m)

    def __str__(self) -> str:
        if self.horizontal:
            return f"horizontal path at {self.observer_m / 1e3:g} km"
        return f"{self.observer_m / 1e3:g} km -> {self.end_m / 1e3:g} km at {self.angle_deg:g} deg"


@dataclass(frozen=True)
class SpectralPath:
    """Spectra of one path, in our units.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
        Ascending.
    transmittance : ndarray (V,) or None
        Of the whole path, 0 to 1; None where the file has none.
    path_radiance : ndarray (V,) or None
        Thermal emission of the air towards the observer, including its scattered part but not surface and sunlight, W
        m-2 sr-1 (cm-1)-1; None where the file has none.
    solar : mapping of str to ndarray (V,)
        Sunlight, where the file has it. ``scattered`` (of which ``single_scattered``) and ``ground_reflected`` (thermal
        and solar; of which ``sun_reflected``) are radiances, W m-2 sr-1 (cm-1)-1; ``at_top``, ``at_observer``,
        ``via_end`` (sun to the path's far end to the observer) and ``transmitted`` are irradiances, W m-2 (cm-1)-1.
    total_radiance, surface_emission : ndarray (V,) or None
        Total radiance at the observer, and the part that the surface emits, W m-2 sr-1 (cm-1)-1.
    geometry : PathGeometry or None
        None where the file does not give it.
    code : str
        Code and file type.
    source : str
        File and run number.
    line : int
        First line of the run's numbers in the file, for messages.
    model : int or None
        Number of the model atmosphere (1 tropical ... 6 US Standard 1976), if given in the file.
    resolution_cm1 : float or None
        Full width of the slit function, if given in the file.
    surface_temperature_K : float or None
        Temperature of a black surface whose emission, times the path transmittance, has to be subtracted from
        ``total_radiance`` to get the path radiance (libRadtran).
    notes : tuple of str
        Notes for the user.
    changes : tuple of str
        Settings by which the run changed amounts of gases, which are then not those of its profile.
    """

    wavenumber_cm1: Array
    transmittance: Array | None
    path_radiance: Array | None
    geometry: PathGeometry | None
    code: str
    source: str
    line: int
    solar: Mapping[str, Array] = field(default_factory=dict)
    total_radiance: Array | None = None
    surface_emission: Array | None = None
    model: int | None = None
    resolution_cm1: float | None = None
    surface_temperature_K: float | None = None
    notes: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()


def radiance_factor(wavenumber_cm1: Array, unit: RadianceUnit) -> Array:
    """Return factors (V,) that convert radiance (or irradiance) to W m-2 per cm-1.

    d lambda / d nu = 1e4 / nu^2 micrometres per cm-1.
    """
    if unit == "per_cm1":
        return np.ones_like(wavenumber_cm1)
    per_um: Array = 1e4 / wavenumber_cm1**2
    return per_um if unit == "per_um" else per_um * 1e3


def sine_deg(angle_deg: float) -> float:
    """Return the sine of an angle in degrees."""
    return math.sin(math.radians(angle_deg))


def read_text(path: Path, encoding: str = "utf-8") -> str:
    """Return the text of a file; raise CatalogError if it cannot be read."""
    with Reading(path, CatalogError, "not a text file"):
        return path.read_text(encoding=encoding)
