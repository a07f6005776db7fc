"""Requested accuracy of a scene, relative to its band radiances, and the error budget of the approximations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import Problem, ProviderError, ScenarioError
from hcss_twin.core.units import MAX_ACCURACY, MIN_ACCURACY, kelvin_of
from hcss_twin.models.radiance.spectral_grid import SpectralGrid
from hcss_twin.physics.planck import planck
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import few_columns
from hcss_twin.plan.views import views_over_image
from hcss_twin.providers import ColumnSetting, Sun
from hcss_twin.scenario.scenario import Scenario

SHARES: Mapping[str, float] = {
    "numerics": 0.28,
    "spectral_grid": 0.25,
    "wavenumbers": 0.15,
    "thickness": 0.1,
    "layers": 0.1,
    "waves": 0.1,
    "views": 0.05,
    "shadows": 0.03,
    "time": 0.07,
    "other_instants": 0.02,
    "faint_sunlight": 0.05,
}
"""Shares of the accuracy. A pixel has cloud in one layer or in both, or waves: only the largest of the three counts."""


@dataclass(frozen=True)
class Budget:
    """Allowed or measured relative errors of the total radiance, one for each approximation.

    A measured error is 0 if nothing was approximated.

    Attributes
    ----------
    numerics : float
        Streams, azimuth modes and other sizes of the radiance model's solution.
    spectral_grid : float
        Step of the whole grid.
    wavenumbers : float
        Replacing the whole grid by few weighted wavenumbers.
    thickness, layers, waves, views, shadows, time : float
        Interpolation between columns with cloud in one layer and in two, slopes, views, sun paths and instants.
    other_instants : float
        Deriving columns at further instants, or of many streams, from others; it may use what ``time`` leaves.
    faint_sunlight : float
        Omitting negligible sunlight by day.
    """

    numerics: float = 0.0
    spectral_grid: float = 0.0
    wavenumbers: float = 0.0
    thickness: float = 0.0
    layers: float = 0.0
    waves: float = 0.0
    views: float = 0.0
    shadows: float = 0.0
    time: float = 0.0
    other_instants: float = 0.0
    faint_sunlight: float = 0.0

    @property
    def total(self) -> float:
        """Largest sum of these errors in a pixel."""
        somewhere = max(self.thickness, self.layers, self.waves)
        before = self.numerics + self.spectral_grid + self.wavenumbers + somewhere + self.views + self.shadows
        return before + self.time + self.other_instants + self.faint_sunlight


def share_out(accuracy: float) -> Budget:
    """Return the allowed error of each approximation."""
    return Budget(**{name: share * accuracy for name, share in SHARES.items()})


LARGEST_SHARE = 0.3
"""Largest share of the accuracy for rounding; the tables need the rest."""

WAVENUMBERS = 24
"""Number of wavenumbers of each band in the search for the hottest pixel."""

MARGIN_K = 5.0
"""Safety margin for pixels hotter than the hottest one found."""

WAVES_K = 60.0
"""Safety margin for wave glint that is hotter than that of the mean sea."""


@dataclass(frozen=True)
class RequestedAccuracy:
    """Allowed error of a pixel.

    Attributes
    ----------
    relative : float
        Relative to the total radiance of every band: the tolerance of the tables.
    kelvin : float or None
        Error of the brightness temperature, if requested.
    """

    relative: float
    kelvin: float | None = None

    def __str__(self) -> str:
        if self.kelvin is None:
            return f"{self.relative:g} of the band radiance"
        return f"{self.kelvin:g} K of the brightness temperature, {self.relative:.2g} of the band radiance or more"


def requested_accuracy(scenario: Scenario, assembly: Assembly, suns: Sequence[Sun | None]) -> RequestedAccuracy:
    """Convert a scenario's accuracy to a fraction of the radiance that meets it in every band.

    The hotter a pixel, the smaller the fraction that corresponds to 1 K. The hottest pixel therefore decides; it is
    sought among clear columns and those with the thinnest and thickest clouds.

    Parameters
    ----------
    suns : sequence of Sun or None
        Sun at some frames; empty if no radiance is requested.

    Raises
    ------
    ScenarioError
        If a band has no brightness temperature, or the requested kelvin are too accurate for it.
    """
    kelvin = kelvin_of(scenario.accuracy)
    if kelvin is None:
        return RequestedAccuracy(float(scenario.accuracy))
    if not suns:
        return RequestedAccuracy(MAX_ACCURACY, kelvin)
    from hcss_twin.models.radiance.brightness_temperature import COLDEST_K, HOTTEST_K  # not for relative accuracies

    grid = assembly.spectral_grid
    shares = []
    names = [band.name for band in assembly.bands]
    for band, (name, kelvin_there) in enumerate(zip(names, _hottest_K(assembly, suns), strict=True)):
        hottest = kelvin_there + MARGIN_K
        if hottest > HOTTEST_K:
            message = (
                f"{scenario.accuracy!r}: brightness temperature in band '{name}' exceeds {HOTTEST_K:g} K, as with "
                "reflected sunlight at short wavelengths; allowed: a fraction of the radiance"
            )
            raise ScenarioError([Problem("accuracy", message)])
        if kelvin_there < COLDEST_K:
            message = (
                f"{scenario.accuracy!r}: brightness temperature in band '{name}' is below {COLDEST_K:g} K "
                "at every wavenumber; allowed: a fraction of the radiance"
            )
            raise ScenarioError([Problem("accuracy", message)])
        if scenario.sea.waves != "off":
            hottest += WAVES_K
        shares.append(kelvin * relative_slope(grid, band, hottest))
    relative = min(shares)
    if relative < MIN_ACCURACY:
        message = (
            f"{scenario.accuracy!r} is {relative:.1e} of the radiance of pixels in band "
            f"'{names[int(np.argmin(shares))]}'; allowed: {MIN_ACCURACY:g} or more; closest valid choice is "
            f"'{1.01 * kelvin * MIN_ACCURACY / relative:.2g} K'"
        )
        raise ScenarioError([Problem("accuracy", message)])
    return RequestedAccuracy(min(relative, MAX_ACCURACY), kelvin)


def _hottest_K(assembly: Assembly, suns: Sequence[Sun | None]) -> list[float]:
    """Brightness temperature of the brightest column of each band; infinite or 0 outside the tabulated range."""
    from hcss_twin.models.radiance.brightness_temperature import BrightnessTemperature

    _, brightest = extreme_radiances(assembly, suns)
    black = BrightnessTemperature(assembly.spectral_grid, [band.name for band in assembly.bands])
    kelvin = black.where_known(brightest[:, None])[:, 0]
    beyond = np.where(brightest > black.highest_radiance, np.inf, 0.0)
    return [float(hottest_K) for hottest_K in np.where(np.isnan(kelvin), beyond, kelvin)]


def extreme_radiances(assembly: Assembly, suns: Sequence[Sun | None]) -> tuple[Array, Array]:
    """Return the darkest and brightest radiance (B,) of a few columns under some suns, toward centre and corners."""
    columns = few_columns(assembly, WAVENUMBERS)
    settings = dict.fromkeys([assembly.setting(), *_settings_toward_corners(assembly)])
    lit = [setting.under(sun) for sun in dict.fromkeys(suns) for setting in settings]
    totals = np.concatenate(columns.totals_in(assembly.model, lit))
    return np.min(totals, axis=0), np.max(totals, axis=0)


def _settings_toward_corners(assembly: Assembly) -> list[ColumnSetting]:
    """Settings of the corners of the image."""
    corners = [(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    low, high = assembly.transmittance.declares.valid.get("view_zenith", (0.0, 90.0))
    settings = []
    for view in views_over_image(assembly).at(corners):
        # A view that the providers do not support is skipped and listed under the omissions.
        with suppress(ProviderError, ScenarioError):
            if low <= view.zenith_deg <= high:
                settings.append(assembly.setting(view=view))
    return settings


def relative_slope(grid: SpectralGrid, band: int, temperature_K: float) -> float:
    """Relative increase of black-body radiance per kelvin."""
    around = temperature_K + np.array([-0.5, 0.5])
    low, high = planck(grid.wavenumber_cm1[None], around[:, None]) @ grid.weights_cm1[band]
    return float(np.log(high / low))


def largest_kelvin(grid: SpectralGrid, relative: Array, temperature_K: float) -> float:
    """Return relative changes (B,) of radiance as kelvin of a black body, of the band in which that is largest."""
    return max(float(share) / relative_slope(grid, band, temperature_K) for band, share in enumerate(relative))
