"""Cases of the benchmark: what another code needs to compute them, and the Monte Carlo radiance to compare with.

Each case is one NetCDF file beside this module; its variables have units and descriptions of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import NDArray

from hcss_light.monte_carlo import Sunlight
from hcss_light.source import Direction
from hcss_light.voxels import LightError, ScatteringTable, Voxels
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, choose_from

FOLDER = Path(__file__).parent

FIRST_UM, SECOND_UM_K = 1.191042972e8, 14387.76877
"""Constants of Planck's law for radiance in W m-2 sr-1 um-1 of wavelengths in um (CODATA 2018)."""


@dataclass(frozen=True, eq=False)
class Case:
    """One case: clouds on voxels, periodic along x and y, over a black surface without gas.

    Attributes
    ----------
    name, summary : str
    size_m : (float, float)
        Sides of a pixel along x and y.
    edges_m : ndarray (Z + 1,)
        Altitudes between the levels, from the surface on.
    temperature_K : ndarray (Z,)
        Of each level.
    kind : ndarray of int (Z,)
        Number of the particles of each level.
    extinction_m1 : ndarray (X, Y, Z)
        At visible wavelengths.
    bands : tuple of str
    wavelength_um : ndarray (B,)
    relative, albedo : ndarray (K, B)
        Extinction over that at visible wavelengths, and single-scattering albedo, of each kind of particles.
    cosine : ndarray (A,)
        Of the scattering angle, ascending.
    phase : ndarray (K, B, A)
        Phase function, linear in the cosine between them; its mean over the sphere is 1.
    moments : ndarray (K, B, M)
        Its Legendre moments.
    irradiance : ndarray (B,)
        Of the sun on a surface that faces it, W m-2 um-1; 0 in bands without sunlight.
    sun : Direction or None
        Azimuths count from +x toward +y.
    views : tuple of Direction
        Toward the sensor.
    reference_m : float
        Altitude at which lines of sight meet the pixels.
    surface_K : float
    columns : ndarray (N, Z)
        Extinction of uniform clouds whose plane-parallel radiance is known: all combinations of amounts of the kinds.
    column_radiance : ndarray (B, V, N)
        W m-2 sr-1 um-1.
    column_of : ndarray of int (X, Y)
        The uniform cloud that each pixel's column is a part of.
    radiance, noise : ndarray (B, V, X, Y)
        By Monte Carlo, and its standard error; W m-2 sr-1 um-1.
    photons : ndarray of int (B,)
        For each pixel and view.
    """

    name: str
    summary: str
    size_m: tuple[float, float]
    edges_m: Array
    temperature_K: Array
    kind: NDArray[np.int64]
    extinction_m1: Array
    bands: tuple[str, ...]
    wavelength_um: Array
    relative: Array
    albedo: Array
    cosine: Array
    phase: Array
    moments: Array
    irradiance: Array
    sun: Direction | None
    views: tuple[Direction, ...]
    reference_m: float
    surface_K: float
    columns: Array
    column_radiance: Array
    column_of: NDArray[np.int64]
    radiance: Array
    noise: Array
    photons: NDArray[np.int64]

    def black(self, band: int, kelvin: Array | float) -> Array:
        """Return Planck radiance, W m-2 sr-1 um-1."""
        wavelength = self.wavelength_um[band]
        return np.asarray(FIRST_UM / wavelength**5 / np.expm1(SECOND_UM_K / (wavelength * np.asarray(kelvin))))

    def kelvin(self, band: int, radiance: Array | float) -> Array:
        """Return brightness temperature."""
        wavelength = self.wavelength_um[band]
        return np.asarray(
            SECOND_UM_K / wavelength / np.log1p(FIRST_UM / wavelength**5 / np.asarray(radiance, dtype=np.float64))
        )

    def is_sunlit(self, band: int) -> bool:
        """Return whether the sun shines in a band."""
        return self.sun is not None and bool(self.irradiance[band] > 0.0)

    def sunlight(self, band: int) -> Sunlight | None:
        """Return the direct sunlight of a band."""
        if self.sun is None or not self.is_sunlit(band):
            return None
        return Sunlight(self.sun.zenith_deg, self.sun.azimuth_deg, float(self.irradiance[band]))

    def voxels(self, band: int, extinction_m1: Array | None = None) -> Voxels:
        """Return the clouds, or others (X, Y, Z) in their place, at the wavelength of a band."""
        given = self.extinction_m1 if extinction_m1 is None else extinction_m1
        return Voxels(
            given, self.edges_m, self.size_m, self.albedo[self.kind, band], np.zeros(self.kind.size),
            self.black(band, self.temperature_K), surface_source=float(self.black(band, self.surface_K)),
            kind=self.kind, per=self.relative[self.kind, band],
        )  # fmt: skip

    def scattering(self, band: int) -> list[ScatteringTable]:
        """Return the phase function of each kind of particles."""
        return [ScatteringTable(self.cosine, phase) for phase in self.phase[:, band]]

    def displaced_m(self, view: Direction) -> tuple[float, float]:
        """Return how far along x and y from a pixel its lines of sight enter the top of the domain."""
        north, east = (self.edges_m[-1] - self.reference_m) * view.vector[:2] / view.vector[2]
        return float(north), float(east)


def case_names() -> list[str]:
    """Return the names of the cases, those of one layer first."""
    return sorted((path.stem for path in FOLDER.glob("*.nc")), key=lambda name: (name.startswith("two"), name))


def load_case(name: str) -> Case:
    """Read a case by its name.

    Raises
    ------
    LightError
        If there is none of this name.
    """
    names = case_names()
    if name not in names:
        raise LightError(f"case: '{name}'; {choose_from(name, names)}")
    return read_case(FOLDER / f"{name}.nc")


def read_case(path: Path) -> Case:
    """Read a case from its file."""
    with Reading(path, LightError), netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)

        def array(name: str) -> Array:
            return np.asarray(file[name][...], dtype=np.float64)

        def whole(name: str) -> NDArray[np.int64]:
            return np.asarray(file[name][...], dtype=np.int64)

        lit = bool(np.any(array("solar_irradiance") > 0.0))
        return Case(
            name=path.stem,
            summary=file.title,
            size_m=(float(file["x"].pixel_size), float(file["y"].pixel_size)),
            edges_m=array("edge_altitude"),
            temperature_K=array("temperature"),
            kind=whole("kind"),
            extinction_m1=array("extinction"),
            bands=tuple(map(str, file["band"][:])),
            wavelength_um=array("wavelength"),
            relative=array("relative_extinction"),
            albedo=array("single_scattering_albedo"),
            cosine=array("cosine"),
            phase=array("phase_function"),
            moments=array("legendre_moment"),
            irradiance=array("solar_irradiance"),
            sun=Direction(float(array("sun_zenith")), float(array("sun_azimuth"))) if lit else None,
            views=tuple(map(Direction, array("view_zenith").tolist(), array("view_azimuth").tolist())),
            reference_m=float(array("reference_altitude")),
            surface_K=float(array("surface_temperature")),
            columns=array("column_extinction"),
            column_radiance=array("column_radiance"),
            column_of=whole("column_of"),
            radiance=array("radiance"),
            noise=array("radiance_error"),
            photons=whole("photons"),
        )
