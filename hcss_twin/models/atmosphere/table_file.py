"""Reader and writer of the ``hcss-atmosphere-table`` format (catalogs/atmospheres/README.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import Writing, open_format
from hcss_twin.core.netcdf import NetcdfFile
from hcss_twin.models.atmosphere.same_profile import stated_gases
from hcss_twin.physics.profile import EARTH_RADIUS_M, GASES, Profile
from hcss_twin.version import __version__

__all__ = ["AtmosphereTable"]

FORMAT = "hcss-atmosphere-table"
FORMAT_VERSION = 1
DIMENSIONS = ("target_altitude_m", "zenith_deg", "wavenumber_cm1")
LEVELS = ("level_altitude_m", "level_pressure_Pa", "level_temperature_K")
GAS_LEVELS = {f"level_{gas}": gas for gas in GASES}
"""Optional variables: mixing ratios of the profile."""


@dataclass(frozen=True)
class AtmosphereTable:
    """Transmittance and path radiance from targets to space, and the profile that they were computed with.

    Attributes
    ----------
    target_altitude_m : ndarray (H,)
    zenith_deg : ndarray (Z,)
        At the surface point.
    wavenumber_cm1 : ndarray (V,)
    transmittance, path_radiance : ndarray (H, Z, V)
        1 and W m-2 sr-1 (cm-1)-1.
    profile : Profile
    resolution_cm1 : float
    source : str
    interpolation_error : float or None
        Largest measured error of transmittance between the nodes; None if not measured.
    """

    target_altitude_m: Array
    zenith_deg: Array
    wavenumber_cm1: Array
    transmittance: Array
    path_radiance: Array
    profile: Profile
    resolution_cm1: float
    source: str
    interpolation_error: float | None = None

    @classmethod
    def read(cls, path: Path) -> AtmosphereTable:
        """Read and check an atmosphere table.

        Raises
        ------
        CatalogError
            If the file is not in this format, lacks a variable, or has impossible values.
        """
        with open_format(path, FORMAT, FORMAT_VERSION) as dataset:
            names: list[str] = [*DIMENSIONS, "transmittance", "path_radiance", *LEVELS]
            missing = [name for name in names if name not in dataset.variables]
            if missing:
                raise CatalogError(f"{path}: variables missing: {', '.join(missing)}")
            for name in ("transmittance", "path_radiance"):
                if dataset.variables[name].dimensions != DIMENSIONS:
                    raise CatalogError(f"{path}: {name} must have the dimensions {', '.join(DIMENSIONS)}")
            names += [name for name in GAS_LEVELS if name in dataset.variables]
            values = {name: np.ma.filled(dataset.variables[name][:].astype(np.float64), np.nan) for name in names}
            resolution = float(getattr(dataset, "resolution_cm1", 0.0))
            source = str(getattr(dataset, "source", path.name))
            measured = getattr(dataset, "interpolation_error_transmittance_max", None)
        _check(path, values)
        gases = {gas: values[name] for name, gas in GAS_LEVELS.items() if name in values}
        altitude_m, pressure_Pa, temperature_K = (values[name] for name in LEVELS)
        profile = Profile(path.stem, altitude_m, pressure_Pa, temperature_K, gases)
        return cls(
            values["target_altitude_m"],
            values["zenith_deg"],
            values["wavenumber_cm1"],
            values["transmittance"],
            values["path_radiance"],
            profile,
            resolution,
            source,
            None if measured is None else float(measured),
        )

    def write(self, path: Path, attributes: Mapping[str, str]) -> None:
        """Write the table, data in single precision; an existing file is never replaced by a partial one.

        Parameters
        ----------
        path : Path
            File to write.
        attributes : mapping of str to str
            Further global attributes, for example ``title`` and ``origin``.
        """
        coordinates = {
            "target_altitude_m": self.target_altitude_m,
            "zenith_deg": self.zenith_deg,
            "wavenumber_cm1": self.wavenumber_cm1,
        }
        profile = self.profile
        levels = dict(zip(LEVELS, (profile.altitude_m, profile.pressure_Pa, profile.temperature_K), strict=True))
        # Those of a model atmosphere, which the user's file lacks, need not be those of the runs.
        stated = stated_gases(profile)
        levels |= {name: profile.mixing_ratio[gas] for name, gas in GAS_LEVELS.items() if gas in stated}
        with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
            file.setncatts(
                {
                    "format": FORMAT,
                    "format_version": FORMAT_VERSION,
                    "title": "imported atmosphere",
                    "source": self.source,
                    "origin": "imported from files of another code",
                    "license": "that of the code's output",
                    "created_with": f"hcss-twin {__version__}",
                    "resolution_cm1": self.resolution_cm1,
                    "aerosol": "as in the imported runs",
                    "two_way_solar_transmittance": "not stored",
                    "earth_radius_m": EARTH_RADIUS_M,
                    **attributes,
                }
            )
            for name, values in coordinates.items():
                file.createDimension(name, values.size)
            file.createDimension("level", self.profile.altitude_m.size)
            for name, values in {**coordinates, **levels}.items():
                variable = file.createVariable(name, "f8", (name if name in coordinates else "level",))
                variable.units, variable.long_name = _UNITS[name]
                variable[:] = values
            for name, values in (("transmittance", self.transmittance), ("path_radiance", self.path_radiance)):
                variable = file.createVariable(name, "f4", DIMENSIONS, compression="zlib", shuffle=True)
                variable.units, variable.long_name = _UNITS[name]
                variable[:] = values


def _check(path: Path, values: dict[str, Array]) -> None:
    for name, array in values.items():
        if not np.all(np.isfinite(array)):
            raise CatalogError(f"{path}: {name} has missing or infinite values")
    for name in (*DIMENSIONS, "level_altitude_m"):
        # One height or angle is enough for a table that is used only there.
        fewest = 1 if name in ("target_altitude_m", "zenith_deg") else 2
        if values[name].size < fewest or np.any(np.diff(values[name]) <= 0):
            raise CatalogError(f"{path}: {name} must ascend strictly over at least {fewest} nodes")
    transmittance = values["transmittance"]
    if np.any(transmittance < 0) or np.any(transmittance > 1):
        raise CatalogError(f"{path}: transmittance must lie in 0..1")
    if np.any(values["path_radiance"] < 0):
        raise CatalogError(f"{path}: path_radiance must not be negative")
    for name in ("wavenumber_cm1", "level_pressure_Pa", "level_temperature_K"):
        if np.any(values[name] <= 0.0):
            raise CatalogError(f"{path}: {name} must be above 0")
    for name in GAS_LEVELS:
        if name in values and (np.any(values[name] < 0.0) or np.any(values[name] > 1.0)):
            raise CatalogError(f"{path}: {name} must lie in 0..1")
    if np.any(np.diff(values["level_pressure_Pa"]) >= 0.0):
        raise CatalogError(f"{path}: level_pressure_Pa must descend strictly")
    if values["target_altitude_m"][0] < 0.0 or values["zenith_deg"][0] < 0.0:
        raise CatalogError(f"{path}: target_altitude_m and zenith_deg must not be negative")
    if values["zenith_deg"][-1] >= 90.0:
        raise CatalogError(f"{path}: zenith_deg must stay below 90")


_UNITS = {
    "target_altitude_m": ("m", "altitude of the target"),
    "zenith_deg": ("degree", "zenith angle of the straight path where it meets the surface"),
    "wavenumber_cm1": ("cm-1", "wavenumber"),
    "level_altitude_m": ("m", "altitude of the profile's levels"),
    "level_pressure_Pa": ("Pa", "pressure, logarithmic between levels"),
    "level_temperature_K": ("K", "temperature, linear between levels"),
    **{name: ("1", f"mole fraction of {gas.upper()}") for name, gas in GAS_LEVELS.items()},
    "transmittance": ("1", "total transmittance, target to space"),
    "path_radiance": ("W m-2 sr-1 (cm-1)-1", "thermal emission of the path, from space"),
}
