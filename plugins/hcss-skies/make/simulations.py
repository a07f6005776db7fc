"""Compare simulations of published cases with what their publications found: ``python make/simulations.py FILE ...``.

The published numbers were written before the first run, from memory, with their figures: of the articles, only
abstracts could be checked. Those of ATEX and RF01 give no numbers; that of RF02 says that the water path is steady,
that entrainment is at the low end of the measured range, and that the variance of w is about half of the measured one.
They are of the intercomparisons, whose models disagree among one another; figures were not digitised. Profiles and
forcings of the cases were compared with the public set-ups of CLUBB, DALES, PINACLES and PyCLES. Files are those of
``hcss skies simulate CASE``.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Published:
    """One number of a publication."""

    name: str
    value: str
    low: float
    high: float
    where: str


BOMEX = "Siebesma et al. 2003, J. Atmos. Sci. 60, 1201"
RF01 = "Stevens et al. 2005, Mon. Weather Rev. 133, 1443"
ATEX = "Stevens et al. 2001, J. Atmos. Sci. 58, 1870"
PUBLISHED = {
    "BOMEX": [
        Published("cloud cover", "8 to 17 %, mean of models 13 %", 0.08, 0.17, f"{BOMEX}, fig. 2a, last 3 h"),
        Published("liquid water path, g m-2", "below 20, no number in the text", 1.0, 20.0, f"{BOMEX}, fig. 2b"),
        Published("greatest cloud fraction", "about 6 %, near the base", 0.045, 0.075, f"{BOMEX}, fig. 3"),
        Published("lowest base, m", "about 500", 400.0, 600.0, f"{BOMEX}, sect. 4"),
        Published("highest top, m", "to about 2000", 1400.0, 2200.0, f"{BOMEX}, sect. 4"),
        Published("w of cloudy cells, m/s, at most", "about 1", 0.7, 1.5, f"{BOMEX}, cloud ensemble"),
        Published("tendency of theta_l below 500 m, K/day", "about 1", 0.0, 2.0, f"{BOMEX}, sect. 4"),
    ],
    "ATEX": [
        Published("cloud cover", "models about .2 to .9", 0.2, 0.9, f"{ATEX}, last 3 h"),
        Published("greatest cloud fraction", "about that of the cover: stratiform, at the top", 0.15, 0.9, f"{ATEX}"),
        Published("highest top, m", "about 1500", 1350.0, 1650.0, f"{ATEX}"),
        Published("lowest base, m", "about 700", 600.0, 800.0, f"{ATEX}"),
    ],
    "DYCOMS": [
        Published("cloud cover", "observed .99; models .2 to 1", 0.8, 1.0, f"{RF01}, last 2 h"),
        Published("liquid water path, g m-2", "observed 60; models about 20 to 60", 20.0, 60.0, f"{RF01}, last 2 h"),
        Published("w variance at most, m2 s-2", "observed about .4 (radar, aircraft)", 0.2, 0.6, f"{RF01}"),
        Published("entrainment, cm/s", "observed .38 +- .04; models .3 to .6", 0.30, 0.60, f"{RF01}"),
    ],
}  # fmt: skip
"""What each publication says, and the range that counts as agreement."""


def measured(file: netCDF4.Dataset, kind: str) -> dict[str, float]:
    """Return the numbers of a run: means over the last 3 h (BOMEX, ATEX) or 2 h (DYCOMS), or half of shorter ones."""

    def of(name: str) -> NDArray[np.float64]:
        return np.asarray(file.variables[name][:], float)

    time, z = of("statistics_time"), of("z")
    span = min({"DYCOMS": 2.0}.get(kind, 3.0) * 3600.0, 0.5 * time[-1])
    late = time >= time[-1] - span
    found = {
        "cloud cover": of("cloud_cover")[late].mean(),
        "liquid water path, g m-2": of("mean_liquid_water_path")[late].mean(),
        "greatest cloud fraction": of("cloud_fraction")[late].mean(0).max(),
        "lowest base, m": of("lowest_base")[late].mean(),
        "highest top, m": of("highest_top")[late].mean(),
        "w of cloudy cells, m/s, at most": of("cloud_w")[late].mean(0)[z < 1700.0].max(),
        "w variance at most, m2 s-2": of("w_variance")[late].mean(0).max(),
    }
    low = of("mean_theta_l")[late][:, z < 500.0].mean(1)
    seconds = time[late]
    found["tendency of theta_l below 500 m, K/day"] = np.polyfit(seconds, low, 1)[0] * 86400.0
    # entrainment: rise of the height where the mean water is 8 g/kg, and subsidence there (divergence 3.75e-6 s-1)
    water = of("total_water")[late]
    heights = [np.interp(-8.0, -w[z > 600.0], z[z > 600.0]) for w in water]
    found["entrainment, cm/s"] = 100.0 * (np.polyfit(seconds, heights, 1)[0] + 3.75e-6 * float(np.mean(heights)))
    return {name: float(value) for name, value in found.items()}


def main(paths: list[str]) -> None:
    """Print a table for each file."""
    for path in paths:
        with netCDF4.Dataset(Path(path)) as file:
            print(f"{path}: {file.title}")
            kind = next((name for name in PUBLISHED if name in file.title), None)
            if kind is None:
                print("  no publication has results for it, or none is written down")
                continue
            found = measured(file, kind)
            for each in PUBLISHED[kind]:
                value = found[each.name]
                verdict = "agrees" if each.low <= value <= each.high else "differs"
                print(f"  {each.name:40} {value:8.3g}  {verdict:8} published: {each.value} ({each.where})")


if __name__ == "__main__":
    main(sys.argv[1:])
