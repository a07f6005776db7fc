"""Writer of the ``hcss-atmosphere-table`` format."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from hcss_twin.atmosphere.table_file import DIMENSIONS, FORMAT, FORMAT_VERSION, AtmosphereTable
from hcss_twin.physics.profile import EARTH_RADIUS_M
from hcss_twin.version import __version__

_UNITS = {
    "target_altitude_m": ("m", "altitude of the target"),
    "zenith_deg": ("degree", "zenith angle of the straight path where it meets the surface"),
    "wavenumber_cm1": ("cm-1", "wavenumber"),
    "level_altitude_m": ("m", "altitude of the profile's levels"),
    "level_pressure_Pa": ("Pa", "pressure, logarithmic between levels"),
    "level_temperature_K": ("K", "temperature, linear between levels"),
    "transmittance": ("1", "total transmittance, target to space"),
    "path_radiance": ("W m-2 sr-1 (cm-1)-1", "thermal emission of the path, from space"),
}


def write_atmosphere_table(path: Path, table: AtmosphereTable, attributes: Mapping[str, str]) -> None:
    """Write a table; a partial file never takes the place of an existing one.

    Parameters
    ----------
    path : Path
        File to write.
    table : AtmosphereTable
        What to write; the tables in single precision, coordinates in double.
    attributes : mapping of str to str
        Further global attributes, for example ``title`` and ``origin``.
    """
    import netCDF4

    coordinates = {
        "target_altitude_m": table.target_altitude_m,
        "zenith_deg": table.zenith_deg,
        "wavenumber_cm1": table.wavenumber_cm1,
    }
    levels = {
        "level_altitude_m": table.profile.altitude_m,
        "level_pressure_Pa": table.profile.pressure_Pa,
        "level_temperature_K": table.profile.temperature_K,
    }
    draft = path.with_name(f".{path.name}.draft")
    try:
        with netCDF4.Dataset(draft, "w", format="NETCDF4") as file:
            file.setncatts(
                {
                    "format": FORMAT,
                    "format_version": FORMAT_VERSION,
                    "title": "imported atmosphere",
                    "source": table.source,
                    "origin": "imported from files of another code",
                    "license": "that of the code's output",
                    "created_with": f"hcss-twin {__version__}",
                    "resolution_cm1": table.resolution_cm1,
                    "aerosol": "as in the imported runs",
                    "two_way_solar_transmittance": "not stored",
                    "earth_radius_m": EARTH_RADIUS_M,
                    **attributes,
                }
            )
            for name, values in coordinates.items():
                file.createDimension(name, values.size)
            file.createDimension("level", table.profile.altitude_m.size)
            for name, values in {**coordinates, **levels}.items():
                dimension = name if name in coordinates else "level"
                variable = file.createVariable(name, "f8", (dimension,))
                variable.setncatts({"units": _UNITS[name][0], "long_name": _UNITS[name][1]})
                variable[:] = values
            for name, values in (
                ("transmittance", table.transmittance),
                ("path_radiance", table.path_radiance),
            ):
                variable = file.createVariable(name, "f4", DIMENSIONS, compression="zlib", shuffle=True)
                variable.setncatts({"units": _UNITS[name][0], "long_name": _UNITS[name][1]})
                variable[:] = values
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)
