"""Ice crystals relative to spheres of the same volume and projected area, from a published table.

The table (recipe ``ice_yang_2013.py``) has the band averages of Yang et al. (2013) as used in RRTMGP, divided by those
of Mie spheres. The spheres provide the spectral detail within and between bands.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.files import open_format

FORMAT, VERSION = "hcss-ice-optics", 1
_RATIOS = ("extinction_ratio", "absorption_ratio", "asymmetry_ratio")


@dataclass(frozen=True, eq=False)
class CrystalRatios:
    """Ratios of crystal to sphere properties.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (B,)
        Logarithmic centres of the bands, ascending.
    effective_diameter_um : ndarray (D,)
        3/2 of volume over projected area, ascending.
    ratios : ndarray (3, B, D)
        Of extinction, of absorption, and of one minus the asymmetry parameter.
    """

    wavenumber_cm1: Array
    effective_diameter_um: Array
    ratios: Array

    def at(self, effective_diameter_um: float, wavenumber_cm1: Array) -> Array:
        """Return ratios (3, V): linear in diameter and ln wavenumber, constant beyond the outermost band centres.

        Raises
        ------
        ValueError
            If the diameter lies outside the table.
        """
        sizes = self.effective_diameter_um
        low, high = float(sizes[0]), float(sizes[-1])
        if not low <= effective_diameter_um <= high:
            closest = low if effective_diameter_um < low else high
            raise ValueError(
                f"effective radius {effective_diameter_um / 2:.4g} um of ice: the table of crystals allows "
                f"{low / 2:.4g} to {high / 2:.4g}; closest is {closest / 2:.4g}"
            )
        upper = int(np.clip(np.searchsorted(sizes, effective_diameter_um), 1, sizes.size - 1))
        share = (effective_diameter_um - sizes[upper - 1]) / (sizes[upper] - sizes[upper - 1])
        of_size = (1.0 - share) * self.ratios[:, :, upper - 1] + share * self.ratios[:, :, upper]
        position, centres = np.log(wavenumber_cm1), np.log(self.wavenumber_cm1)
        return np.stack([np.interp(position, centres, each) for each in of_size])


def load_crystals(catalog: Catalog, name: str, roughness: str) -> CrystalRatios:
    """Read a table from ``optics/<name>.nc`` or a user file in that format.

    Raises
    ------
    CatalogError
        If the table is missing, is damaged, has another format, or lacks the roughness.
    """
    path = catalog.find(name, "optics", ".nc")
    with open_format(path, FORMAT, VERSION) as dataset:
        try:
            names = [str(each) for each in dataset["roughness"][:]]
            if roughness not in names:
                raise CatalogError(f"{path}: no roughness '{roughness}'; it has {', '.join(names)}")
            row = names.index(roughness)
            limits = np.asarray(dataset["band_limits"][:], dtype=np.float64)
            diameter = np.asarray(dataset["effective_diameter"][:], dtype=np.float64)
            ratios = np.stack([np.asarray(dataset[each][row], dtype=np.float64) for each in _RATIOS])
        except (IndexError, OSError, RuntimeError) as error:
            raise CatalogError(f"{path}: damaged: {error}") from error
    _check(path, limits, diameter, ratios)
    return CrystalRatios(np.sqrt(limits[:, 0] * limits[:, 1]), diameter, ratios)


def _check(path: Path, limits: Array, diameter: Array, ratios: Array) -> None:
    if ratios.shape != (3, limits.shape[0], diameter.size) or diameter.size < 2 or limits.shape[1:] != (2,):
        raise CatalogError(f"{path}: ratios of shape {ratios.shape} do not fit bands and diameters")
    if not (np.all(np.diff(diameter) > 0.0) and np.all(np.diff(limits[:, 0] * limits[:, 1]) > 0.0)):
        raise CatalogError(f"{path}: effective_diameter and band_limits must increase")
    ascending = np.all((limits[:, 0] > 0.0) & (limits[:, 1] > limits[:, 0]))
    if not (ascending and np.all(np.isfinite(limits)) and diameter[0] > 0.0 and np.isfinite(diameter[-1])):
        raise CatalogError(f"{path}: effective_diameter and band_limits must be finite, above 0, and limits ascend")
    if not (np.all(np.isfinite(ratios)) and np.all(ratios > 0.0)):
        raise CatalogError(f"{path}: ratios must be above 0")
