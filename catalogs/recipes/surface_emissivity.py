"""Regenerate ``surfaces/emissivity.csv``.

Land: reflectances of surface types from NPOESS, as in the Community Radiative Transfer Model (CRTM) of NOAA/NESDIS
(P. van Delst, ``Create_NPOESS_EmisCoeff.f90``, 2011; public domain, US government), at the wavelengths of that table.
Ice: 1 - Fresnel reflectance at normal incidence of ``optical_constants/ice.csv``. Snow: one value, our choice, at all
wavelengths; from 8 to 14 um near the zenith, J. Dozier and S. G. Warren, Water Resour. Res. 18, 1424 (1982), compute
0.98 to 0.99. Coarse grains emit less (J. W. Salisbury et al., J. Geophys. Res. 99, 24235, 1994).

Run as ``python catalogs/recipes/surface_emissivity.py``.
"""

from __future__ import annotations

import numpy as np
from _table_file import CATALOGS, Column, TableFile, write_table

WAVELENGTH_UM = "2 2.5 3 3.5 4 4.5 5 5.5 6 6.5 7 7.5 8 8.5 9 9.5 10 11 12 13 14 15"
REFLECTANCE = {
    "land": ".069 .090 .044 .092 .164 .179 .185 .178 .060 .072 .048 .036 .038 .048 .057 .060 .067 .090 .075 .068 .054 "
    ".048",
    "vegetation": ".029 .018 .034 .038 .043 .039 .034 .032 .027 .034 .036 .036 .036 .036 .036 .036 .036 .036 .045 .036 "
    ".018 .018",
    "forest": ".038 .020 .038 .048 .038 .038 .038 .038 .038 .038 .038 .038 .038 .038 .038 .038 .038 .038 .050 .038 "
    ".019 .019",
    "tundra": ".087 .065 .050 .087 .099 .124 .104 .095 .041 .055 .039 .032 .045 .046 .053 .056 .057 .056 .047 .043 "
    ".041 .040",
    "soil": ".075 .050 .040 .070 .140 .125 .118 .100 .060 .050 .040 .030 .030 .040 .050 .050 .045 .040 .025 .030 .020 "
    ".020",
    "sand": ".680 .325 .315 .500 .400 .150 .050 .050 .150 .100 .100 .100 .100 .100 .100 .090 .080 .020 .020 .020 .020 "
    ".020",
    "rock": ".200 .050 .100 .200 .120 .180 .070 .050 .070 .080 .050 .040 .100 .110 .130 .140 .120 .050 .030 .020 .020 "
    ".020",
}
"""Of the NPOESS types grass_soil, irrigated_low_vegetation, broadleaf_forest, tundra, compacted_soil, sand and rock."""

ICE_UM = (2.6, 2.7, 2.8, 2.9, 3.05, 3.1, 3.15, 3.2, 3.3)
"""Further wavelengths, at which the reflectance of ice changes strongly."""

SNOW = 0.985
TYPES = {
    "land": "half grass, half soil (NPOESS grass_soil)",
    "vegetation": "NPOESS irrigated_low_vegetation",
    "forest": "NPOESS broadleaf_forest",
    "tundra": "NPOESS tundra",
    "soil": "NPOESS compacted_soil",
    "sand": "NPOESS sand",
    "rock": "NPOESS rock",
    "ice": "smooth ice Ih",
    "snow": "snow of fine grains, one value at all wavelengths (our choice)",
}


def ice_reflectance(wavelength_um: list[float]) -> list[float]:
    """Return the Fresnel reflectance of ice at normal incidence."""
    with (CATALOGS / "optical_constants" / "ice.csv").open(encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    known, n, k = np.loadtxt(lines[1:], delimiter=",", unpack=True)
    n, k = np.interp(wavelength_um, known, n), np.interp(wavelength_um, known, k)
    return [float(each) for each in ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)]


def main() -> None:
    """Write the table."""
    nodes = [float(each) for each in WAVELENGTH_UM.split()]
    wavelength = sorted([*nodes, *ICE_UM])
    columns = {
        name: [1.0 - float(np.interp(each, nodes, [float(r) for r in text.split()])) for each in wavelength]
        for name, text in REFLECTANCE.items()
    }
    columns["ice"] = [1.0 - each for each in ice_reflectance(wavelength)]
    columns["snow"] = [SNOW] * len(wavelength)
    table = TableFile(
        title="Emissivity of surfaces of the Earth",
        source="land: 1 - reflectance of NPOESS surface types, as in the Community Radiative Transfer Model of "
        "NOAA/NESDIS (Create_NPOESS_EmisCoeff.f90, P. van Delst 2011); ice: Warren and Brandt, J. Geophys. Res. 113, "
        "D14220 (2008), by Fresnel's equations at normal incidence; snow: after Dozier and Warren, Water Resour. Res. "
        "18, 1424 (1982)",
        rights="NPOESS table: public domain (US government); others: facts",
        made_by="recipes/surface_emissivity.py",
        columns=(
            Column("wavelength_um", "um", "wavelength"),
            *(Column(name, "1", f"emissivity: {text}") for name, text in TYPES.items()),
        ),
        rows=[[f"{each:g}", *(f"{columns[name][row]:.4f}" for name in TYPES)] for row, each in enumerate(wavelength)],
        remarks=("Linear in wavelength between the rows.",),
    )
    write_table(CATALOGS / "surfaces" / "emissivity.csv", table)


if __name__ == "__main__":
    main()
