"""Fits of the inputs that the paper does not state to its numbers.

``python -m hcss_paper.fits`` prints them in less than half a minute; ``--write`` also writes data/fitted-inputs.json.
"""

from __future__ import annotations

import json
import sys
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, least_squares, minimize_scalar

from hcss_paper.inputs import FITTED_FILE, effective_cover, printed_row, published, suns_of_table_5, suns_of_table_6
from hcss_paper.scene import BANDS, BlackSurface, black_surface, scene
from hcss_paper.tables_8_and_9 import SEED, mean_measures
from hcss_twin.core.arrays import Array
from hcss_twin.physics.planck import planck
from hcss_twin.plan.plan import Plan

COVERS = {
    "Scenario3": ("table_2", "Scenario3", "3.0-5.0"),
    "Scenario4": ("table_2", "Scenario4", "3.0-5.0"),
    "Table IV, 3-5 um": ("table_4", "3.0-5.0", "3.0-5.0"),
    "Scenario5": ("table_2", "Scenario5", "8.0-14.0"),
    "Scenario6": ("table_2", "Scenario6", "8.0-14.0"),
    "Table IV, 8-14 um": ("table_4", "8.0-14.0", "8.0-14.0"),
}
"""Rows of Tables II and IV that have a cloud: table, row, band."""

SHARED = (
    "sea temperature",
    "glint scale",
    "cover at no coverage",
    "cover per coverage",
    "cover of Table IV, 3-5 um",
    "cover of Scenario5",
    "cover of Scenario6",
    "cover of Table IV, 8-14 um",
    "cover of Table V",
)
"""Inputs fitted together to Tables II and IV (without 2.7-3.0 um), V, VI and VII."""

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

SUNS_WEIGHT = 4.0
"""Weight of Tables V and VI in the fit: their residual is the printed rounding, a fourth of that of the other rows."""

_TOGETHER = (
    "least squares of the relative differences of Tables II and IV (3-5 and 8-14 um), V, VI and VII together, with "
    f"weight {SUNS_WEIGHT:g} for V and VI"
)


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
        # Glint of suns at 1 au, seen from above: irradiance is proportional to the inverse square of the distance.
        middle = list(BANDS).index("3.0-5.0")
        self.glint_of_suns = {
            table: np.array(
                [
                    sun.distance_au**2
                    * plans[0].assembly.model.clear(grid.wavenumber_cm1, sun)["sea_reflected_sun"]
                    @ self._weights_cm1[:, middle]
                    for sun in suns
                ]
            )
            for table, suns in (("table_5", suns_of_table_5()), ("table_6", suns_of_table_6()))
        }
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


def shared_rows(terms: ColumnTerms, inputs: Array) -> dict[str, Array]:
    """Return the rows of Tables II, IV (without 2.7-3.0 um), V, VI and VII for inputs in the order of :data:`SHARED`.

    Tables V to VII are seen from above. The cloud top is at 6 km (the highest of type ``simulated``, Table III) with
    the air temperature there, 249.2 K. Where the paper prints a coverage C, the effective cover is a + b C.
    """
    given = dict(zip(SHARED, inputs, strict=True))
    clear = terms.clear(given["sea temperature"], given["glint scale"])
    middle = list(BANDS).index("3.0-5.0")
    rows = {}
    for name, (_, _, band) in COVERS.items():
        place = list(BANDS).index(band)
        cover = effective_cover(name, given)
        rows[name] = (1 - cover) * clear[:, place] + cover * terms.opaque[:, place]
    dark = terms.clear(given["sea temperature"], 0.0)[0, middle]
    for name, table in (("Table V", "table_5"), ("Table VI", "table_6")):
        cover = effective_cover(name, given)
        bright = dark + given["glint scale"] * terms.glint_of_suns[table]
        rows[name] = (1 - cover) * bright + cover * terms.opaque[0, middle]
    covers = np.array(
        [effective_cover("Table VII", given, percent / 100.0) for percent in published()["table_7"]["coverage_pct"]]
    )
    rows["Table VII"] = (1 - covers) * clear[0, middle] + covers * terms.opaque[0, middle]
    return rows


def printed_shared_rows() -> dict[str, Array]:
    """Return the printed rows that :func:`shared_rows` computes: 85 numbers in nine rows."""
    rows = {name: printed_row(table, row) for name, (table, row, _) in COVERS.items()}
    for name, table in (("Table V", "table_5"), ("Table VI", "table_6")):
        rows[name] = np.array([row[-1] for row in published()[table]["rows"]], dtype=np.float64)
    rows["Table VII"] = np.array(published()["table_7"]["radiance"], dtype=np.float64)
    return rows


_START = (291.0, 0.16, 0.19, 0.22, 0.27, 0.22, 0.19, 0.18, 0.25)


def fit_shared(terms: ColumnTerms, without: str = "") -> dict[str, float]:
    """Fit all inputs of :data:`SHARED` together.

    Parameters
    ----------
    terms : ColumnTerms
    without : str
        Row to leave out: the others alone decide the inputs, except the cover that only this row has, which is then
        fitted to it alone.
    """
    printed = printed_shared_rows()
    weights = {name: SUNS_WEIGHT if name in ("Table V", "Table VI") else 1.0 for name in printed}
    own = f"cover of {without}"
    free = np.array([name != own for name in SHARED])

    def residuals(values: Array, chosen: Array, names: tuple[str, ...], inputs: Array) -> Array:
        inputs = inputs.copy()
        inputs[chosen] = values
        found = shared_rows(terms, inputs)
        return np.concatenate([weights[name] * (found[name] / printed[name] - 1.0) for name in names])

    inputs = np.array(_START)
    scale = np.array([1.0] + [0.01] * (len(SHARED) - 1))
    for chosen, names in ((free, tuple(name for name in printed if name != without)), (~free, (without,))):
        if np.any(chosen):
            found = least_squares(residuals, inputs[chosen], x_scale=scale[chosen], args=(chosen, names, inputs))
            inputs[chosen] = found.x
    return dict(zip(SHARED, map(float, inputs), strict=True))


def fit_table_4_short_wave(terms: ColumnTerms, sea_temperature_K: float) -> dict[str, float]:
    """Fit the glint scale of the 2.7-3.0 um row of Table IV, without cloud: with a free cover, the cover becomes 0."""
    printed, emitted = printed_row("table_4", "2.7-3.0"), terms.clear(sea_temperature_K, 0.0)[:, 0]
    left, slope = 1.0 - emitted / printed, terms.glint[:, 0] / printed
    return {"short-wave glint scale": float(slope @ left / (slope @ slope))}


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


def refit() -> dict[str, float]:
    """Fit every input again, rounded as in the file."""
    terms = column_terms()
    found = fit_shared(terms)
    found |= fit_table_4_short_wave(terms, round(found["sea temperature"], _digits("sea temperature")))
    found |= fit_surfaces() | fit_table_8()
    return {name: round(value, _digits(name)) for name, value in found.items()}


def _digits(name: str) -> int:
    """Return the number of decimals in the file."""
    return 3 if _described(name)["unit"] == "K" else 4


def _described(name: str) -> dict[str, str]:
    """Return unit, meaning and origin of an input."""
    if name.startswith("cover of "):
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
    "glint scale": ("1", "factor on the sun glint of all tables except 2.7-3.0 um", _TOGETHER),
    "cover at no coverage": ("1", "effective cover of opaque cloud at a coverage of 0 (3-5 um)", _TOGETHER),
    "cover per coverage": ("1", "change of the effective cover with the printed coverage (3-5 um)", _TOGETHER),
    "short-wave glint scale": ("1", "factor on the sun glint, 2.7-3.0 um row of Table IV", _SHORT),
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
