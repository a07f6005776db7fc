"""Ratios of crystals to spheres from published bulk optics: shared by the recipes of ice tables.

Ratios are formed to Mie spheres of equal volume-to-area ratio (Grenfell and Warren, J. Geophys. Res. 104, 31697, 1999)
with effective variance 0.1, averaged over each band with Planck's function at 245 K (thermal bands) or 5778 K, so that
a provider can put the spectral detail of spheres between the bands. The ratios belong to the centres of the bands;
those of extinction and absorption are such that their linear interpolation gives the published means of the bands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import netCDF4
import numpy as np

from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import Writing
from hcss_twin.models.optics.bulk import bulk_properties
from hcss_twin.models.optics.size_distribution import gamma_distribution, water_content_kg_m3
from hcss_twin.models.refractive_index import RefractiveIndex
from hcss_twin.physics.planck import planck

VARIANCE = 0.1
NODES, ROUNDS = 12, 40
MIN_CO_ALBEDO = 1e-4
"""Below it the published digits of the albedo leave too few of the absorption."""

LARGEST_CM1 = 33333.0


@dataclass(frozen=True)
class Spectra:
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


THERMAL_CM1 = 3250.0
"""Highest limit of bands that are averaged with thermal radiation, unless said otherwise."""


def spheres(
    limits: np.ndarray, diameter_um: float, index: RefractiveIndex, thermal_cm1: float = THERMAL_CM1
) -> Spectra:
    """Spheres at the nodes of bands (B, 2), cm-1; those up to ``thermal_cm1`` count as thermal."""
    cloud = gamma_distribution("ice", diameter_um / 2.0, VARIANCE, 1e-3)
    mass = water_content_kg_m3(cloud) * 1e3
    nodes, gauss = np.polynomial.legendre.leggauss(NODES)
    rows = []
    for low, high in limits:
        thermal = high <= thermal_cm1
        wavenumber = np.minimum(low + (high - low) * 0.5 * (nodes + 1.0), LARGEST_CM1)
        bulk = bulk_properties(cloud, index, 1e4 / wavenumber, 100 if thermal else 20)
        weight = gauss * planck(wavenumber, 245.0 if thermal else 5778.0)
        rows.append(
            (wavenumber, weight / weight.sum(), bulk.extinction_m1 / mass, bulk.absorption_m1 / mass, bulk.asymmetry)
        )
    columns = (np.array(each) for each in zip(*rows, strict=True))
    return Spectra(*columns, centres=np.sqrt(limits[:, 0] * limits[:, 1]))


def ratios_to(spheres: Spectra, published: np.ndarray, weak: np.ndarray) -> np.ndarray:
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


RATIOS = {
    "extinction_ratio": "published extinction per mass over that of spheres, at the band centre",
    "absorption_ratio": (
        "the same of absorption; where the published albedo exceeds 0.9999, that of the next band of lower wavenumber"
    ),
    "asymmetry_ratio": "one minus the published asymmetry parameter, over that of spheres",
}

VariableRow = tuple[str, tuple[str, ...], np.ndarray, str, str]
"""Name, dimensions, values, units and meaning of a variable."""

OF_CRYSTALS = ("roughness", "band", "size")


def write_ice_table(
    path: Path,
    attributes: Mapping[str, str],
    roughness: Sequence[str],
    variables: Sequence[VariableRow],
    ratios: np.ndarray,
) -> None:
    """Write a table of ratios (3, R, B, D) and the published numbers that they stand for."""
    path.parent.mkdir(exist_ok=True)
    with Writing(path, CatalogError) as draft, netCDF4.Dataset(draft, "w") as out:
        out.format, out.format_version = "hcss-ice-optics", 1
        out.title = "Bulk optics of ice crystals relative to spheres of equal volume and projected area"
        for name, text in attributes.items():
            setattr(out, name, text)
        for name, count in zip(OF_CRYSTALS, ratios.shape[1:], strict=True):
            out.createDimension(name, count)
        out.createDimension("limit", 2)
        names = out.createVariable("roughness", str, ("roughness",))
        names[:] = np.array(roughness, dtype=object)
        rows = [(name, OF_CRYSTALS, ratios[row], "1", text) for row, (name, text) in enumerate(RATIOS.items())]
        for name, dimensions, values, units, text in (*variables, *rows):
            variable = out.createVariable(name, "f8", dimensions, zlib=True, fletcher32=True)
            variable.units, variable.long_name = units, text
            variable[:] = values
