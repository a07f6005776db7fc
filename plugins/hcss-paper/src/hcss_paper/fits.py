"""Fits of the inputs that the paper does not state to its numbers.

``python -m hcss_paper.fits`` prints them in less than half a minute; ``--write`` also writes data/fitted-inputs.json.
"""

from __future__ import annotations

import json
import sys
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, least_squares, minimize_scalar

from hcss_paper.inputs import FITTED_FILE, printed_row, published, suns_of_table_5, suns_of_table_6
from hcss_paper.scene import BANDS, BlackSurface, black_surface, scene
from hcss_paper.tables_8_and_9 import SEED, mean_measures
from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import planck
from hcss_twin.plan.plan import Plan

COVERS = {
    "cover of Scenario3": ("table_2", "Scenario3", "3.0-5.0"),
    "cover of Scenario4": ("table_2", "Scenario4", "3.0-5.0"),
    "cover of Table IV, 3-5 um": ("table_4", "3.0-5.0", "3.0-5.0"),
    "cover of Scenario5": ("table_2", "Scenario5", "8.0-14.0"),
    "cover of Scenario6": ("table_2", "Scenario6", "8.0-14.0"),
    "cover of Table IV, 8-14 um": ("table_4", "8.0-14.0", "8.0-14.0"),
}
"""Rows with separate cloud covers: table, row, band."""

SURFACES = {
    "MODTRAN surface of Scenario3": ("table_2", "Scenario3", "3.0-5.0"),
    "MODTRAN surface of Scenario4": ("table_2", "Scenario4", "3.0-5.0"),
    "MODTRAN surface of Scenario5": ("table_2", "Scenario5", "8.0-14.0"),
    "MODTRAN surface of Scenario6": ("table_2", "Scenario6", "8.0-14.0"),
    "MODTRAN surface of Table IV, 3-5 um": ("table_4", "3.0-5.0", "3.0-5.0"),
    "MODTRAN surface of Table IV, 8-14 um": ("table_4", "8.0-14.0", "8.0-14.0"),
    "MODTRAN surface of Table IV, 2.7-3.0 um": ("table_4", "2.7-3.0", "2.7-3.0"),
}
"""MODTRAN columns, each with its own black-surface temperature: table, row, band."""

_TOGETHER = "least squares of the relative differences of the six rows of Tables II and IV together"
_NADIR = "least squares over the 32 radiances of Tables V and VI, seen from above, the sun at 1 au"


class ColumnTerms:
    """Terms of the ``as-printed`` columns of Tables II and IV, which can be combined for any inputs.

    At each wavenumber, sea emission is black-body emission times emissivity and transmittance; all other terms are
    linear in the inputs.
    """

    def __init__(self) -> None:
        plans = [scene("as-printed", float(view), tuple(BANDS.values())) for view in published()["view_zenith_deg"]]
        grid = plans[0].spectral_grid
        self._wavenumber_cm1, self._weights_cm1 = grid.wavenumber_cm1, grid.weights_cm1.T
        black = planck(grid.wavenumber_cm1, plans[0].assembly.sea_temperature_K)
        spectra = [_spectra(plan) for plan in plans]
        self._passing = np.array([sea / black for sea, *_ in spectra])
        self.air, self.glint, self.opaque = (
            np.array([each[place] @ self._weights_cm1 for each in spectra]) for place in (1, 2, 3)
        )

    def clear(self, sea_temperature_K: float, glint_scale: float) -> Array:
        """Radiance (views, bands) of the clear column."""
        sea = (self._passing * planck(self._wavenumber_cm1, sea_temperature_K)) @ self._weights_cm1
        result: Array = sea + self.air + glint_scale * self.glint
        return result


@lru_cache(maxsize=1)
def column_terms() -> ColumnTerms:
    """Return the terms, computed once."""
    return ColumnTerms()


def _spectra(plan: Plan) -> tuple[Array, Array, Array, Array]:
    """Return sea emission, air emission and glint of the clear column, and the opaque column, each (V,)."""
    nu, sun = plan.spectral_grid.wavenumber_cm1, plan.sun_track.at(0.0)
    clear = plan.assembly.model.clear(nu, sun)
    opaque = plan.assembly.model.cloudy(nu, np.array([[plan.layers[0].thickness_max_m]]), sun)
    whole: Array = np.sum([term[0] for term in opaque.values()], axis=0)
    return clear["sea_emission"], clear["path_emission"], clear["sea_reflected_sun"], whole


def fit_tables_2_and_4(terms: ColumnTerms) -> dict[str, float]:
    """Fit sea temperature, glint scale and the cover of each row, with fixed cloud-top height and temperature.

    The cloud top is at 6 km (the highest of type ``simulated``, Table III) with the air temperature there, 249.2 K.
    Other heights and temperatures fit the rows as well: they, sea temperature and covers are degenerate.
    """
    places = list(BANDS)

    def residuals(inputs: Array) -> Array:
        clear = terms.clear(inputs[0], inputs[1])
        rows = []
        for cover, (table, row, band) in zip(inputs[2:], COVERS.values(), strict=True):
            mixed = (1 - cover) * clear[:, places.index(band)] + cover * terms.opaque[:, places.index(band)]
            rows.append(mixed / printed_row(table, row) - 1.0)
        return np.concatenate(rows)

    found = least_squares(residuals, [291.0, 0.16] + [0.25] * len(COVERS), x_scale=[1.0, 0.01] + [0.01] * 6).x
    return dict(zip(("sea temperature", "glint scale", *COVERS), map(float, found), strict=True))


def fit_table_4_short_wave(terms: ColumnTerms, sea_temperature_K: float) -> dict[str, float]:
    """Fit cover and glint scale of the 2.7-3.0 um row of Table IV separately."""
    printed = printed_row("table_4", "2.7-3.0")

    def residuals(inputs: Array) -> Array:
        cover, glint_scale = inputs
        clear = terms.clear(sea_temperature_K, glint_scale)[:, 0]
        result: Array = ((1 - cover) * clear + cover * terms.opaque[:, 0]) / printed - 1.0
        return result

    cover, glint_scale = least_squares(residuals, [0.4, 0.1], bounds=([0.0, 0.0], [1.0, 10.0])).x
    return {"short-wave cover": float(cover), "short-wave glint scale": float(glint_scale)}


def fit_tables_5_and_6(terms: ColumnTerms, sea_temperature_K: float) -> dict[str, float]:
    """Fit the cover of each table and a common glint scale, for a nadir view in 3-5 um.

    Absolute differences are minimised, because most of the residual is rounding, which is the same in all rows.
    """
    band = list(BANDS).index("3.0-5.0")
    thermal, opaque = terms.clear(sea_temperature_K, 0.0)[0, band], terms.opaque[0, band]
    plan = scene("as-printed", 0.0, (BANDS["3.0-5.0"],), 1.0)
    nu, weights = plan.spectral_grid.wavenumber_cm1, plan.spectral_grid.weights_cm1[0]
    suns, printed = [], []
    for table, of_table in (("table_5", suns_of_table_5()), ("table_6", suns_of_table_6())):
        # Glint of a sun at 1 au: irradiance is proportional to the inverse square of the distance.
        glints = [
            sun.distance_au**2 * plan.assembly.model.clear(nu, sun)["sea_reflected_sun"] @ weights for sun in of_table
        ]
        suns.append(np.array(glints))
        printed.append(np.array([row[-1] for row in published()[table]["rows"]]))

    def residuals(inputs: Array) -> Array:
        rows = [
            (1 - cover) * (thermal + inputs[0] * glint) + cover * opaque - radiance
            for cover, glint, radiance in zip(inputs[1:], suns, printed, strict=True)
        ]
        return np.concatenate(rows)

    scale, five, six = least_squares(residuals, [0.16, 0.27, 0.27], x_scale=0.01).x
    return {"nadir glint scale": float(scale), "cover of Table V": float(five), "cover of Table VI": float(six)}


def fit_surfaces() -> dict[str, float]:
    """Fit the temperature of the black surface below each MODTRAN column."""
    found = {}
    for name, (table, row, band) in SURFACES.items():
        printed, air = printed_row(table, row, "Modtran"), black_surface(BANDS[band])

        def misfit(kelvin: float, air: BlackSurface = air, printed: Array = printed) -> float:
            return float(np.sum((air.radiance(kelvin) / printed - 1.0) ** 2))

        found[name] = float(minimize_scalar(misfit, bounds=(250.0, 330.0), method="bounded").x)
    return found


def fit_table_8() -> dict[str, float]:
    """Find the coverage at which clouds of type ``simulated`` have the printed diagonal peak."""
    _, _, peak, _ = published()["table_8"]["sim"]

    def excess(coverage: float) -> float:
        return mean_measures("simulated", coverage, SEED)["DP"] - float(peak)

    return {"coverage of Table VIII": float(brentq(excess, 0.1, 0.4, xtol=1e-5))}


def fit_table_7() -> dict[str, float]:
    """Fit a straight line over coverage to Table VII."""
    table = published()["table_7"]
    slope, level = np.polyfit(np.array(table["coverage_pct"]) / 100.0, np.array(table["radiance"]), 1)
    return {"Table VII without cloud": float(level), "Table VII per coverage": float(slope)}


def refit() -> dict[str, float]:
    """Fit every input again, rounded as in the file."""
    terms = column_terms()
    found = fit_tables_2_and_4(terms)
    sea = found["sea temperature"] = round(found["sea temperature"], _digits("sea temperature"))
    found |= fit_table_4_short_wave(terms, sea) | fit_tables_5_and_6(terms, sea)
    found |= fit_surfaces() | fit_table_7() | fit_table_8()
    return {name: round(value, _digits(name)) for name, value in found.items()}


def _digits(name: str) -> int:
    """Return the number of decimals in the file."""
    return 2 if _described(name)["unit"] == "K" else 4


def _described(name: str) -> dict[str, str]:
    """Return unit, meaning and origin of an input."""
    if name in COVERS:
        meaning = f"effective cover of opaque cloud, {name.removeprefix('cover of ')}"
        return {"unit": "1", "meaning": meaning, "how": _TOGETHER}
    if name in SURFACES:
        meaning = f"black surface of the MODTRAN column, {name.removeprefix('MODTRAN surface of ')}"
        return {"unit": "K", "meaning": meaning, "how": "least squares of the column's relative differences"}
    unit, meaning, how = _OTHERS[name]
    return {"unit": unit, "meaning": meaning, "how": how}


_SHORT = "least squares of the relative differences of that row alone"
_OTHERS = {
    "sea temperature": ("K", "sea temperature of all tables", _TOGETHER),
    "glint scale": ("1", "factor on the sun glint of Tables II and IV", _TOGETHER),
    "short-wave cover": ("1", "effective cover, 2.7-3.0 um row of Table IV", _SHORT),
    "short-wave glint scale": ("1", "factor on the sun glint, 2.7-3.0 um row of Table IV", _SHORT),
    "nadir glint scale": ("1", "factor on the sun glint of Tables V and VI", _NADIR),
    "cover of Table V": ("1", "effective cover of opaque cloud, Table V", _NADIR),
    "cover of Table VI": ("1", "effective cover of opaque cloud, Table VI", _NADIR),
    "Table VII without cloud": ("W m-2 sr-1", "radiance at no coverage, Table VII", "straight line, least squares"),
    "Table VII per coverage": (
        "W m-2 sr-1",
        "change of radiance from no to full coverage, Table VII",
        "straight line, least squares",
    ),
    "coverage of Table VIII": (
        "1",
        "coverage of the simulated image of Table VIII",
        "the one at which clouds of type simulated have the printed DP",
    ),
}


def document(values: dict[str, float]) -> str:
    """Return the text of the file."""
    about = (
        "Inputs that W. Sun et al. do not state, fitted to the numbers of their tables (tables.json) in the "
        "as-printed model. They are fits and no proof of what the authors used. Written by `python -m "
        "hcss_paper.fits --write`; do not edit. No rights claimed."
    )
    inputs = {name: {"value": value, **_described(name)} for name, value in values.items()}
    return json.dumps({"about": about, "inputs": inputs}, indent=1) + "\n"


if __name__ == "__main__":
    text = document(refit())
    if "--write" in sys.argv[1:]:
        FITTED_FILE.write_text(text, encoding="utf-8")
    print(text, end="")
