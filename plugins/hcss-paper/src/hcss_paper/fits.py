"""Fits of the inputs that the paper does not state to its numbers.

``python -m hcss_paper.fits`` prints them in less than half a minute; ``--write`` also writes data/fitted-inputs.json.
The inputs of :data:`SCENE` are also in the shipped scenario ``baseline``, whose cubes decide the verdicts.
"""

from __future__ import annotations

import json
import sys
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq, least_squares, minimize_scalar

from hcss_paper.inputs import (
    FITTED_FILE,
    coverage_of,
    effective_cover,
    fitted,
    printed_row,
    published,
    suns_of_table_5,
    suns_of_table_6,
)
from hcss_paper.scene import BANDS, BlackSurface, black_surface, scene
from hcss_paper.tables_8_and_9 import SEED, mean_measures
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array, planck

COVERS = {
    "Scenario3": ("table_2", "Scenario3", "3.0-5.0"),
    "Scenario4": ("table_2", "Scenario4", "3.0-5.0"),
    "Table IV, 3-5 um": ("table_4", "3.0-5.0", "3.0-5.0"),
    "Scenario5": ("table_2", "Scenario5", "8.0-14.0"),
    "Scenario6": ("table_2", "Scenario6", "8.0-14.0"),
    "Table IV, 8-14 um": ("table_4", "8.0-14.0", "8.0-14.0"),
}
"""Rows of Tables II and IV that have a cloud: table, row, band."""

SUN_TABLES = {"Table V": "table_5", "Table VI": "table_6"}

SCENE = ("sea temperature", "glint scale", "water content")
"""Inputs of scenario ``baseline``, fitted together to Tables II and IV (without 2.7-3.0 um), V, VI and VII."""

MIXTURE = (
    "sea temperature of the mixture",
    "glint scale of the mixture",
    "cover at no coverage",
    "cover per coverage",
    "cover of Table IV, 3-5 um",
    "cover of Scenario5",
    "cover of Scenario6",
    "cover of Table IV, 8-14 um",
    "cover of Table V",
)
"""Inputs of the mixture of a clear and an opaque column, fitted to the same rows."""

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
"""Weight of Tables V and VI in the fit of the mixture: their residual is the printed rounding, a fourth of others."""

_ROWS = "the relative differences of Tables II and IV (3-5 and 8-14 um), V, VI and VII together"
_TOGETHER = f"least squares of {_ROWS}, with weight {SUNS_WEIGHT:g} for V and VI"
_BY_ROW = f"least squares of {_ROWS}, each of the nine rows with the same weight, at the printed coverages"

_WATER_G_M3 = 1e-3
"""Of the clouds from which the absorption is found: thin enough to be seen through."""


class ColumnTerms:
    """Terms of the ``as-printed`` columns of Tables II and IV, which can be combined for any inputs.

    At each wavenumber, sea emission is black-body emission times emissivity and transmittance, a cloud's emission is
    its emissivity (eq 8) times that of a black cloud with the same top, and all other terms are linear in the inputs.
    """

    def __init__(self) -> None:
        views = [float(view) for view in published()["view_zenith_deg"]]
        thin = {"clouds.water_content": _WATER_G_M3}
        plans = [scene("as-printed", view, tuple(BANDS.values()), thin) for view in views]
        grid, layer = plans[0].spectral_grid, plans[0].layers[0]
        nu = self._wavenumber_cm1 = grid.wavenumber_cm1
        self._weights_cm1 = grid.weights_cm1.T
        # Nodes of the thickness, which eq 7 makes uniform between its ends over the cloudy pixels.
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        low, high = layer.thickness_min_m, layer.thickness_max_m
        self._thickness_m, self._share = low + 0.5 * (1.0 + nodes) * (high - low), 0.5 * weights
        passing, air, glint, black, above = [], [], [], [], []
        for plan in plans:
            sun, assembly = plan.sun_track.at(0.0), plan.assembly
            clear, cloudy = assembly.clear(nu, sun), assembly.cloudy(nu, self._thickness_m[:, None], sun)
            sea = clear["sea_emission"]
            through = cloudy["sea_emission"] / sea
            passing.append(sea / planck(nu, plan.assembly.sea_temperature_K))
            air.append(clear["path_emission"])
            glint.append(clear["sea_reflected_sun"])
            black.append(cloudy["cloud_emission"] / (1.0 - through))
            above.append(cloudy["path_emission"])
        self._passing, self._air, self._black, self._above = map(np.array, (passing, air, black, above))
        self._glint = np.array(glint)
        self._absorption = -np.log(through[-1]) / (self._thickness_m[-1] * _WATER_G_M3)  # m2 g-1
        # Glint of suns at 1 au, seen from above: irradiance is proportional to the inverse square of the distance.
        self._glint_of_suns = {
            name: np.array([sun.distance_au**2 * plans[0].assembly.clear(nu, sun)["sea_reflected_sun"] for sun in suns])
            for name, suns in (("Table V", suns_of_table_5()), ("Table VI", suns_of_table_6()))
        }
        self.opaque = np.array(
            [_opaque_column(scene("as-printed", v, tuple(BANDS.values()), OPAQUE_CLOUD)) for v in views]
        )

    def _bands(self, spectra: Array) -> Array:
        result: Array = spectra @ self._weights_cm1
        return result

    def clear(self, sea_temperature_K: float, glint_scale: float) -> Array:
        """Radiance (views, bands) of the clear column."""
        sea = self._passing * planck(self._wavenumber_cm1, sea_temperature_K)
        return self._bands(sea + self._air + glint_scale * self._glint)

    def glint_of_suns(self, table: str) -> Array:
        """Glint (suns,) of Table V or VI in 3-5 um, seen from above."""
        result: Array = self._bands(self._glint_of_suns[table])[:, _MIDDLE]
        return result

    def scene_rows(self, inputs: Array) -> dict[str, Array]:
        """Return the rows that are means of cubes, for inputs in the order of :data:`SCENE`, at the printed coverages.

        The cubes themselves are in :mod:`hcss_paper.cubes`; these are their means to 1e-3 (a test compares them).
        """
        sea_temperature_K, glint_scale, water_g_m3 = map(float, inputs)
        through = np.exp(-self._absorption * water_g_m3 * self._thickness_m[:, None])
        seen = self._share @ through
        cloud = np.einsum("n,vnk->vk", self._share, (1.0 - through) * self._black + self._above)
        sea = self._passing * planck(self._wavenumber_cm1, sea_temperature_K)
        glint = glint_scale * self._glint
        clear, cloudy = self._bands(sea + glint + self._air), self._bands(cloud + seen * (sea + glint))
        rows = {}
        for name, (_, _, band) in COVERS.items():
            cover, band_index = coverage_of(name), list(BANDS).index(band)
            rows[name] = (1.0 - cover) * clear[:, band_index] + cover * cloudy[:, band_index]
        dark, dark_cloudy = self._bands(sea[0] + self._air[0]), self._bands(cloud[0] + seen * sea[0])
        for name in SUN_TABLES:
            cover, suns = coverage_of(name), glint_scale * self._glint_of_suns[name]
            bright = (1.0 - cover) * (dark + self._bands(suns)) + cover * (dark_cloudy + self._bands(seen * suns))
            rows[name] = bright[:, _MIDDLE]
        covers = np.array(published()["table_7"]["coverage_pct"]) / 100.0
        rows["Table VII"] = (1.0 - covers) * clear[0, _MIDDLE] + covers * cloudy[0, _MIDDLE]
        return rows


_NODES = 8
_MIDDLE = list(BANDS).index("3.0-5.0")

OPAQUE_CLOUD = {
    "clouds": {"type": "paper-simulated", "coverage": 0.3, "top": 6000.0, "anchor": "top", "temperature": 249.2}
}
"""Cloud of the mixture: top at 6 km, the highest of type ``simulated`` (Table III), with the air temperature there."""


@lru_cache(maxsize=1)
def column_terms() -> ColumnTerms:
    """Return the terms, computed once."""
    return ColumnTerms()


def _opaque_column(plan: Plan) -> Array:
    """Return the radiance (bands,) of the thickest cloud."""
    thickest, setting = [plan.layers[0].thickness_max_m], plan.assembly.setting(plan.sun_track.at(0.0))
    result: Array = SpectralGrid.reference_radiance(plan.assembly.model, setting, plan.spectral_grid, thickest)[0]
    return result


def mixture_rows(terms: ColumnTerms, inputs: Array) -> dict[str, Array]:
    """Return the rows of Tables II, IV (without 2.7-3.0 um), V, VI and VII for inputs in the order of :data:`MIXTURE`.

    Tables V to VII are seen from above. Where the paper prints a coverage C, the effective cover is a + b C.
    """
    given = dict(zip(MIXTURE, inputs, strict=True))
    sea_temperature_K, glint_scale = given["sea temperature of the mixture"], given["glint scale of the mixture"]
    clear = terms.clear(sea_temperature_K, glint_scale)
    rows = {}
    for name, (_, _, band) in COVERS.items():
        band_index, cover = list(BANDS).index(band), effective_cover(name, given)
        rows[name] = (1 - cover) * clear[:, band_index] + cover * terms.opaque[:, band_index]
    dark = terms.clear(sea_temperature_K, 0.0)[0, _MIDDLE]
    for name in SUN_TABLES:
        cover = effective_cover(name, given)
        rows[name] = (1 - cover) * (dark + glint_scale * terms.glint_of_suns(name)) + cover * terms.opaque[0, _MIDDLE]
    covers = np.array(
        [effective_cover("Table VII", given, percent / 100.0) for percent in published()["table_7"]["coverage_pct"]]
    )
    rows["Table VII"] = (1 - covers) * clear[0, _MIDDLE] + covers * terms.opaque[0, _MIDDLE]
    return rows


@lru_cache(maxsize=1)
def fitted_mixture() -> dict[str, Array]:
    """Return the rows of the mixture with its fitted inputs."""
    return mixture_rows(column_terms(), np.array([fitted(name) for name in MIXTURE]))


def printed_rows() -> dict[str, Array]:
    """Return the printed rows that both models compute: 85 numbers in nine rows."""
    rows = {name: printed_row(table, row) for name, (table, row, _) in COVERS.items()}
    for name, table in SUN_TABLES.items():
        rows[name] = np.array([row[-1] for row in published()[table]["rows"]], dtype=np.float64)
    rows["Table VII"] = np.array(published()["table_7"]["radiance"], dtype=np.float64)
    return rows


def table_of(row: str) -> str:
    """Return the table of a row of :func:`printed_rows`: ``"Table II"`` for ``"Scenario3"``."""
    return "Table II" if row.startswith("Scenario") else row.partition(",")[0]


def fit_scene(terms: ColumnTerms, without: str = "") -> dict[str, float]:
    """Fit the inputs of :data:`SCENE`.

    Parameters
    ----------
    terms : ColumnTerms
    without : str
        Table to leave out, ``"Table II"``: the others alone decide the inputs.
    """
    printed = {name: row for name, row in printed_rows().items() if table_of(name) != without}

    def residuals(inputs: Array) -> Array:
        found = terms.scene_rows(inputs)
        return np.concatenate([(found[name] / row - 1.0) / np.sqrt(row.size) for name, row in printed.items()])

    found = least_squares(residuals, (285.0, 0.1, 0.01), x_scale=(1.0, 0.01, 0.001))
    return dict(zip(SCENE, map(float, found.x), strict=True))


def fit_mixture(terms: ColumnTerms) -> dict[str, float]:
    """Fit the inputs of :data:`MIXTURE`."""
    printed = printed_rows()

    def residuals(inputs: Array) -> Array:
        found = mixture_rows(terms, inputs)
        weights = {name: SUNS_WEIGHT if name in SUN_TABLES else 1.0 for name in printed}
        return np.concatenate([weights[name] * (found[name] / row - 1.0) for name, row in printed.items()])

    start = (291.0, 0.16, 0.19, 0.22, 0.27, 0.22, 0.19, 0.18, 0.25)
    found = least_squares(residuals, start, x_scale=(1.0,) + (0.01,) * (len(MIXTURE) - 1))
    return dict(zip(MIXTURE, map(float, found.x), strict=True))


def fit_table_4_short_wave(terms: ColumnTerms, sea_temperature_K: float) -> dict[str, float]:
    """Fit the glint scale of the 2.7-3.0 um row of Table IV, without cloud: with a free cover, the cover becomes 0."""
    printed, emitted = printed_row("table_4", "2.7-3.0"), terms.clear(sea_temperature_K, 0.0)[:, 0]
    left, slope = 1.0 - emitted / printed, (terms.clear(sea_temperature_K, 1.0)[:, 0] - emitted) / printed
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
        return mean_measures("paper-simulated", coverage, SEED)["DP"] - float(peak)

    return {"coverage of Table VIII": float(brentq(excess, 0.1, 0.4, xtol=1e-5))}


def refit() -> dict[str, float]:
    """Fit every input again, rounded as in the file."""
    terms = column_terms()
    found = fit_scene(terms) | fit_mixture(terms)
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
    "sea temperature": ("K", "sea temperature", _BY_ROW),
    "glint scale": ("1", "factor on the sun glint, except 2.7-3.0 um", _BY_ROW),
    "water content": ("g m-3", "water content of clouds from 66 m to 3 km, as cumulus of Table III", _BY_ROW),
    "sea temperature of the mixture": ("K", "sea temperature of the mixture", _TOGETHER),
    "glint scale of the mixture": ("1", "factor on the sun glint of the mixture", _TOGETHER),
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
