"""Make ``tests/data/navy-maritime-lowtran7.csv``: transmittance by the LOWTRAN7 Fortran with the Navy maritime aerosol.

Set up the environment of ``us_standard_1976_lowtran7.py``, then run
``python navy_maritime_reference.py navy-maritime-lowtran7.csv``. The paths lead from the sea to space at 60 deg.
"""

import sys

import numpy as np
from _lowtran7 import Run, run_many

# Model atmosphere (1 tropical, 3 mid-latitude winter, 6 US 1976), visibility (0: computed from the wind), wind,
# mean wind of 24 hours, air mass character.
CASES = (
    (1, 0.0, 2.0, 5.0, 1),
    (1, 0.0, 7.0, 7.0, 3),
    (1, 0.0, 15.0, 10.0, 3),
    (1, 0.0, 20.0, 20.0, 1),
    (3, 0.0, 12.0, 12.0, 6),
    (6, 0.0, 3.0, 2.0, 1),
    (6, 15.0, 14.0, 9.0, 10),
)
NAVY_MARITIME, ZENITH_DEG, LOW_CM1, HIGH_CM1, EVERY = 3, 60.0, 500.0, 4500.0, 8

runs = [
    Run(
        model, 0, 0.0, 0.0, ZENITH_DEG, LOW_CM1, HIGH_CM1, to_space=True, haze=NAVY_MARITIME, visibility_km=visibility,
        wind_m_s=wind, wind_24h_m_s=day, air_mass_character=character,
    )
    for model, visibility, wind, day, character in CASES
]  # fmt: skip
table = np.array([runs[0].wavenumbers(), *(out.transmittance for out in run_many(runs))]).T[::EVERY]
lines = ["# transmittance from the sea to space at 60 deg; made by catalogs/recipes/navy_maritime_reference.py"]
lines += ["# columns: wavenumber in cm-1, then model atmosphere/visibility/wind/mean of 24 h/character:"]
lines += ["# " + ", ".join("/".join(f"{value:g}" for value in case) for case in CASES)]
lines += [",".join([f"{row[0]:g}", *(f"{value:.6f}" for value in row[1:])]) for row in table]
with open(sys.argv[1], "w", encoding="ascii") as file:
    file.write("\n".join(lines) + "\n")
