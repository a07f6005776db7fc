"""Examples of skies: two fields of 8 bits with tables of their values, as NetCDF files.

The first field is the height p at which an opaque cloud has the brightness temperature of the pixel. The second is the
excess x, by which the cloud top is above p; it is 0 where the cloud is opaque. A file holds the rank of each pixel,
0 to 255, and the values (m) at these ranks. Ranks are evenly spaced in the normal score, so that a decoded field has
the distribution N(0, 1), which blending requires (E. Heitz and F. Neyret, "High-performance by-example noise using a
histogram-preserving blending operator", Proc. ACM Comput. Graph. Interact. Tech. 1(2), 31, 2018, section 4.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr, ndtri

from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array, CatalogError, NetcdfFile

LEVELS = 256
"""Ranks of a field."""

MAX_SCORE = 4.0
"""Largest normal score: one pixel in 30 000 is beyond it."""

MIN_SIDE, MAX_SIDE = 4, 4096
"""Smallest and largest side of an example in pixels."""

HEIGHT_RANGE_M = -3000.0, 30_000.0
"""Heights that an example may have; negative ones are warmer than the profile at the sea."""

DETAIL_STRENGTHS, DETAIL_EXPONENTS = (0.0, 1.0), (1.2, 4.0)
"""Allowed values of the detail."""

FORMAT = 1

Bytes = NDArray[np.uint8]


@dataclass(frozen=True)
class Detail:
    """Strength and exponent of detail: see ``ExampleParameters``."""

    strength: float
    exponent: float


@dataclass(frozen=True)
class Example:
    """An example of a sky.

    Attributes
    ----------
    opaque : ndarray of uint8 (rows, columns)
        Ranks of p, the height of an opaque cloud of the same brightness temperature; rows northward.
    excess : ndarray of uint8 (rows, columns)
        Ranks of x, cloud-top height less p.
    opaque_m, excess_m : ndarray (256,)
        Heights in m at the ranks, ascending.
    pixel_size_m : float
        Side of a pixel.
    clear_m : float
        p of the clear sky: pixels above it hold cloud.
    kind, source, licence : str
        Kind of clouds, where the example comes from, and the terms of use.
    excess_is_known : bool
        False if x is 0 because the source has one channel.
    detail : Detail or None
        Of the image, extrapolated below its pixel; None if not estimated.
    lapse_K_m : float or None
        Of an image of brightness temperature: p is how much colder than clear sky a pixel is, over this lapse rate.
    """

    opaque: Bytes
    excess: Bytes
    opaque_m: Array
    excess_m: Array
    pixel_size_m: float
    clear_m: float
    kind: str
    source: str
    licence: str
    excess_is_known: bool = True
    detail: Detail | None = None
    lapse_K_m: float | None = None

    @property
    def coverage(self) -> float:
        """Fraction of pixels with p above that of the clear sky."""
        return float(np.mean(self.opaque_m[self.opaque] > self.clear_m))


def make_example(
    opaque_m: Array,
    excess_m: Array | None,
    *,
    pixel_size_m: float,
    clear_m: float,
    kind: str,
    source: str,
    licence: str,
    detail: Detail | None = None,
    lapse_K_m: float | None = None,
) -> Example:
    """Return the example of fields of p and x (rows, columns) in m; without x, it is 0 and flagged as unknown."""
    ranks, table = to_ranks(opaque_m)
    if excess_m is None:
        other, other_table = np.zeros_like(ranks), np.zeros(LEVELS)
    else:
        other, other_table = to_ranks(excess_m, ties=opaque_m)
    return Example(
        ranks, other, table, other_table, float(pixel_size_m), float(clear_m), kind, source, licence,
        excess_m is not None, detail, lapse_K_m,
    )  # fmt: skip


def rank_scores() -> Array:
    """Return the normal scores (256,) of the ranks."""
    return np.linspace(-MAX_SCORE, MAX_SCORE, LEVELS)


def to_ranks(field: Array, ties: Array | None = None) -> tuple[Bytes, Array]:
    """Return the ranks 0 to 255 of a field (rows, columns), and the values (256,) at these ranks.

    Equal values are ordered by ``ties``, then by their surroundings: each would be a plateau of scores otherwise, with
    noise or steps at its edges.
    """
    if field.min() == field.max():
        return np.zeros(field.shape, dtype=np.uint8), np.full(LEVELS, float(field.flat[0]))
    near = gaussian_filter(field, 1.0, mode="reflect").ravel()
    keys = (near, field.ravel()) if ties is None else (near, -ties.ravel(), field.ravel())
    order = np.lexsort(keys)
    score = np.empty(field.size)
    score[order] = ndtri((np.arange(field.size) + 0.5) / field.size)
    ranks = np.rint((score + MAX_SCORE) * ((LEVELS - 1) / (2.0 * MAX_SCORE)))
    ordered = np.sort(field.ravel())
    table = np.interp(ndtr(rank_scores()) * field.size - 0.5, np.arange(field.size), ordered)
    return np.clip(ranks, 0, LEVELS - 1).astype(np.uint8).reshape(field.shape), table


def write_example(path: Path, example: Example) -> None:
    """Write an example as NetCDF; heights are rounded to 0.1 m. Raises CatalogError if it could not be read again."""
    _check(path, example)
    with Writing(path, CatalogError, "NetCDF") as draft, NetcdfFile(draft, "w") as file:
        file.setncatts(
            {
                "title": f"Example of a sky: {example.kind}", "hcss_skies_format": FORMAT, "kind": example.kind,
                "source": example.source, "license": example.licence, "pixel_size_m": example.pixel_size_m,
                "clear_m": example.clear_m, "excess_is_known": int(example.excess_is_known),
            }
        )  # fmt: skip
        if example.detail is not None:
            file.setncatts({"detail": example.detail.strength, "detail_exponent": example.detail.exponent})
        if example.lapse_K_m is not None:
            file.lapse_K_m = example.lapse_K_m
        for name, size in zip(("y", "x", "rank"), (*example.opaque.shape, LEVELS), strict=True):
            file.createDimension(name, size)
        for name, ranks, table, what in (
            (
                "opaque",
                example.opaque,
                example.opaque_m,
                "height of an opaque cloud of the same brightness temperature",
            ),
            ("excess", example.excess, example.excess_m, "cloud-top height above that height"),
        ):
            coded = file.createVariable(f"{name}_rank", "u1", ("y", "x"), zlib=True, complevel=9, fill_value=False)
            # differences along x compress to three quarters of the size
            coded[:] = np.diff(ranks, axis=1, prepend=np.uint8(0))
            coded.long_name = f"rank of the {what}, differences along x modulo 256"
            values = file.createVariable(f"{name}_m", "f4", ("rank",), fill_value=False)
            values[:] = np.round(table, 1)
            values.setncatts({"units": "m", "long_name": f"{what}, at each rank"})


def read_example(path: Path) -> Example:
    """Read an example.

    Raises
    ------
    CatalogError
        If the file is damaged, is no example, or has values out of range.
    """
    with Reading(path, CatalogError, "not an example of a sky, or damaged").netcdf() as file:
        if getattr(file, "hcss_skies_format", None) != FORMAT:
            raise CatalogError(f"{path}: no example of a sky; `hcss skies import` makes one from an image")
        file.set_auto_mask(False)
        opaque, excess = (np.cumsum(file[name][:], axis=1, dtype=np.uint8) for name in ("opaque_rank", "excess_rank"))
        opaque_m, excess_m = (np.asarray(file[name][:], dtype=np.float64) for name in ("opaque_m", "excess_m"))
        example = Example(
            opaque, excess, opaque_m, excess_m, float(file.pixel_size_m), float(file.clear_m), str(file.kind),
            str(file.source), str(file.license), bool(file.excess_is_known),
            Detail(float(file.detail), float(file.detail_exponent)) if "detail" in file.ncattrs() else None,
            float(file.lapse_K_m) if "lapse_K_m" in file.ncattrs() else None,
        )  # fmt: skip
    _check(path, example)
    return example


def _check(path: Any, example: Example) -> None:
    """Raise CatalogError unless the parts of an example fit together and are in range."""
    low, high = HEIGHT_RANGE_M
    wrong = ""
    if example.opaque.ndim != 2 or example.opaque.shape != example.excess.shape:
        wrong = f"fields of {example.opaque.shape} and {example.excess.shape}; allowed: the same rows and columns"
    elif not MIN_SIDE <= min(example.opaque.shape) <= max(example.opaque.shape) <= MAX_SIDE:
        wrong = f"{' x '.join(map(str, example.opaque.shape))} pixels; allowed: sides of {MIN_SIDE} to {MAX_SIDE}"
    elif any(table.shape != (LEVELS,) for table in (example.opaque_m, example.excess_m)):
        wrong = f"tables of other length than {LEVELS}"
    elif not all(
        np.all((table >= low) & (table <= high)) and np.all(np.diff(table) >= 0.0)
        for table in (example.opaque_m, example.excess_m)
    ):
        wrong = f"heights that do not ascend, or outside {low:g} to {high:g} m"
    elif not 1.0 <= example.pixel_size_m <= 1e5:
        wrong = f"pixel_size_m {example.pixel_size_m:g}; allowed: 1 to 100000"
    elif example.detail is not None and not (
        DETAIL_STRENGTHS[0] <= example.detail.strength <= DETAIL_STRENGTHS[1]
        and DETAIL_EXPONENTS[0] <= example.detail.exponent <= DETAIL_EXPONENTS[1]
    ):
        wrong = f"{example.detail}; allowed: a strength of 0 to 1 and an exponent of 1.2 to 4"
    elif example.lapse_K_m is not None and not 0.0 < example.lapse_K_m < 1.0:
        wrong = f"lapse_K_m {example.lapse_K_m:g}; allowed: above 0, below 1"
    elif not low <= example.clear_m <= high:
        wrong = f"clear_m {example.clear_m:g}; allowed: {low:g} to {high:g}"
    if wrong:
        raise CatalogError(f"{path}: {wrong}")
