"""Scores of radiance on the cases of the benchmark, and results of other codes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from hcss_light.cases.case import Case
from hcss_light.cases.models import MODELS
from hcss_light.voxels import LightError
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Array


@dataclass(frozen=True)
class Score:
    """How one model differs from Monte Carlo in one band and view of a case.

    Attributes
    ----------
    case, band, model : str
    sunlit : bool
    view_deg, azimuth_deg : float
        Of the view.
    bias, noise : float
        Difference of the domain mean, and the noise that Monte Carlo leaves in it, over the mean.
    rms, pixel_noise : float
        Difference of pixels without the noise of Monte Carlo, and this noise, over the mean.
    least : float
        The rms that is not distinguished from 0, over the mean.
    bias_K, noise_K, rms_K, pixel_noise_K, least_K : float
        The same in kelvin of brightness temperature; noise and rms in proportion to radiance at its mean.
    """

    case: str
    band: str
    model: str
    sunlit: bool
    view_deg: float
    azimuth_deg: float
    bias: float
    noise: float
    rms: float
    pixel_noise: float
    least: float
    bias_K: float
    noise_K: float
    rms_K: float
    pixel_noise_K: float
    least_K: float

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers by name."""
        return asdict(self)


def score(case: Case, band: int, view: int, model: str, radiance: Array) -> Score:
    """Compare radiance (X, Y) of a model with Monte Carlo."""
    given, noise = case.radiance[band, view], case.noise[band, view]
    mean, away = float(np.mean(given)), radiance - given
    squares = float(np.mean(noise**2))
    # Results of another Monte Carlo code may have noise of their own, which stays in the rms.
    rms = np.sqrt(max(float(np.mean(away**2)) - squares, 0.0))
    pixel = np.sqrt(squares)
    # The sample variance of as many normal numbers is uncertain by its square root of 2 / N.
    least = pixel * (2.0 / noise.size) ** 0.25
    numbers = np.array([np.mean(away), pixel / np.sqrt(noise.size), rms, pixel, least])
    step = 1e-4 * mean
    per_K = float(case.kelvin(band, mean + step) - case.kelvin(band, mean - step)) / (2.0 * step)
    kelvin = numbers * per_K
    # Large biases are not in proportion to radiance.
    kelvin[0] = case.kelvin(band, max(mean + numbers[0], 1e-6 * mean)) - case.kelvin(band, mean)
    toward = case.views[view]
    return Score(
        case.name, case.bands[band], model, case.is_sunlit(band), toward.zenith_deg, toward.azimuth_deg,
        *(numbers / mean).tolist(), *kelvin.tolist(),
    )  # fmt: skip


def scores(case: Case, models: Sequence[str]) -> Iterator[Score]:
    """Yield the scores of our models; ``slant`` has none with several layers."""
    for band, view, model in product(range(len(case.bands)), range(len(case.views)), models):
        if model == "slant" and len(np.unique(case.kind)) > 1:
            continue
        yield score(case, band, view, model, MODELS[model](case, band, view))


def read_results(case: Case, path: Path) -> Array:
    """Return the radiance (B, V, X, Y) that another code wrote for a case.

    Raises
    ------
    LightError
        If the file has no variable ``radiance`` of the shape of the case, in its unit and with finite numbers.
    """
    with Reading(path, LightError), netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        if "radiance" not in file.variables:
            raise LightError(f"{path}: variables {', '.join(file.variables) or 'none'}; allowed: radiance among them")
        variable = file["radiance"]
        unit, known = getattr(variable, "units", "none"), "W m-2 sr-1 um-1"
        if unit != known:
            raise LightError(f"{path}: radiance.units: '{unit}'; allowed: '{known}'")
        values = np.asarray(variable[...], dtype=np.float64)
    if values.shape != case.radiance.shape:
        raise LightError(f"{path}: radiance: shape {values.shape}; allowed: {case.radiance.shape} (band, view, x, y)")
    if not np.all(np.isfinite(values)) or np.min(values) < 0.0:
        raise LightError(f"{path}: radiance: {np.min(values)} to {np.max(values)}; allowed: finite, from 0 on")
    return values


def scores_of_results(case: Case, path: Path, code: str) -> Iterator[Score]:
    """Yield the scores of a code's results for a case."""
    values = read_results(case, path)
    for band, view in product(range(len(case.bands)), range(len(case.views))):
        yield score(case, band, view, code, values[band, view])


def entry(case: Case) -> dict[str, Any]:
    """Return what a list tells of a case."""
    away = [f"{view.zenith_deg:g} deg" for view in case.views]
    sun = "night" if case.sun is None else f"sun at {case.sun.zenith_deg:g} deg"
    points = " x ".join(map(str, case.column_of.shape))
    text = f"{points} pixels of {case.size_m[0]:g} m; {', '.join(case.bands)}; views at {' and '.join(away)}; {sun}"
    return {"name": case.name, "summary": case.summary, "text": text, "photons": case.photons.tolist()}


def _cell(score: Score | None) -> str:
    """Return bias and rms, in per cent with sunlight and in kelvin without; an rms within its noise as a limit."""
    if score is None:
        return "-"
    numbers = (score.bias_K, score.rms_K, score.least_K)
    bias, rms, least = (100.0 * each for each in (score.bias, score.rms, score.least)) if score.sunlit else numbers
    places, unit = (1, "%") if score.sunlit else (2, "K")
    spread = f"{rms:.{places}f}" if rms > least else f"< {max(least, 10.0**-places):.{places}f}"
    return f"{bias:+.{places}f} / {spread} {unit}"


def table(found: Sequence[Score]) -> list[list[str]]:
    """Return rows of a table, the first with the headings: a row for each case, band and view."""
    models = list(dict.fromkeys(each.model for each in found))
    rows = [["case", "band", "view", "Monte Carlo, noise of mean / pixel", *models]]
    cells: dict[tuple[str, str, str], dict[str, Score]] = {}
    for each in found:
        view = f"{each.view_deg:g}" if each.view_deg == 0.0 else f"{each.view_deg:g} / {each.azimuth_deg:g}"
        cells.setdefault((each.case, each.band, view), {})[each.model] = each
    for (case, band, view), by_model in cells.items():
        some = next(iter(by_model.values()))
        noise = (
            f"{100.0 * some.noise:.2f} / {100.0 * some.pixel_noise:.1f} %"
            if some.sunlit
            else f"{some.noise_K:.3f} / {some.pixel_noise_K:.2f} K"
        )
        rows.append([case, band, view, noise, *(_cell(by_model.get(model)) for model in models)])
    return rows
