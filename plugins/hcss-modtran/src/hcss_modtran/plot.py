"""Figures of transmittance providers: the HCSS paper's Figs 15 and 16, and comparisons of two providers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.files import Writing
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.providers import (
    Array,
    AtmosphereInputs,
    Catalog,
    CatalogError,
    HcssError,
    Kind,
    Profile,
    TransmittanceProvider,
    choose_from,
    to_space,
)
from hcss_twin.providers.registry.registry import Registry

if TYPE_CHECKING:
    from matplotlib.axes import Axes


BANDS_UM = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))
"""Bands of the HCSS paper."""

ZENITHS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)
HEIGHTS_M = (0.0, 1000.0, 3000.0, 6000.0, 10_000.0)
RANGE_UM = (2.5, 14.3)

_STEP_CM1 = 5.0


@dataclass(frozen=True)
class AtmosphereSource:
    """A provider with its atmosphere and its label in figures."""

    label: str
    provider: TransmittanceProvider
    profile: Profile


@dataclass(frozen=True)
class AtmosphereSpectra:
    """Spectra of one source.

    Attributes
    ----------
    label : str
    wavenumber_cm1 : ndarray (V,)
    zenith_deg : ndarray (Z,)
        Of ``by_angle``, at the lowest height.
    height_m : ndarray (H,)
        Of ``by_height``, at the smallest zenith angle.
    by_angle, by_height : tuple of ndarray
        Transmittance and path radiance, shapes (Z, V) and (H, V); radiance in W m-2 sr-1 (cm-1)-1.
    """

    label: str
    wavenumber_cm1: Array
    zenith_deg: Array
    height_m: Array
    by_angle: tuple[Array, Array]
    by_height: tuple[Array, Array]


def open_source(name: str, profile: str = "us-standard-1976") -> AtmosphereSource:
    """Resolve the name of a provider or catalog table, or the path of a table file.

    Raises
    ------
    CatalogError
        If it is none of them.
    ProviderError
        If the provider cannot be constructed.
    """
    catalog = Catalog()
    tables, registry = catalog.names("atmospheres", ".nc"), Registry.discover()
    if name.endswith(".nc") or name in tables:
        entry = registry.resolve(Kind.ATMOSPHERE, "hcss-twin/table")
        of_table = AtmosphereTable.read(catalog.find(name, "atmospheres", ".nc")).profile
        table = registry.create(entry, AtmosphereInputs(of_table, catalog), {"file": name})
        return AtmosphereSource(Path(name).stem, table, of_table)
    names = registry.names(Kind.ATMOSPHERE)
    if name not in names:
        known = choose_from(name, (*names, *tables))
        raise CatalogError(f"'{name}' is neither a provider nor an atmosphere table nor a .nc file; {known}")
    loaded = load_profile(profile, catalog)
    provider = registry.create(registry.resolve(Kind.ATMOSPHERE, name), AtmosphereInputs(loaded, catalog))
    return AtmosphereSource(name, provider, loaded)


def sample(
    sources: Sequence[AtmosphereSource],
    zenith_deg: Sequence[float] = ZENITHS_DEG,
    height_m: Sequence[float] = HEIGHTS_M,
    range_um: tuple[float, float] = RANGE_UM,
) -> list[AtmosphereSpectra]:
    """Evaluate sources on common wavenumbers, angles and heights that all of them cover.

    Raises
    ------
    CatalogError
        If they share no wavenumber, angle or height.
    """
    wavenumber = _common_wavenumbers(sources, range_um)
    zenith = _common_nodes(sources, "view_zenith", zenith_deg, "zenith angle (deg)")
    height = _common_nodes(sources, "target_altitude_m", height_m, "height (m)")
    return [_evaluate(source, wavenumber, zenith, height) for source in sources]


def _evaluate(source: AtmosphereSource, wavenumber: Array, zenith: Array, height: Array) -> AtmosphereSpectra:
    base, nadir = float(height[0]), float(zenith[0])
    provider, profile = source.provider, source.profile
    angles = provider.transmittance(wavenumber, [to_space(base, float(angle)) for angle in zenith])
    heights = provider.transmittance(wavenumber, [to_space(float(altitude_m), nadir) for altitude_m in height])
    glow = np.stack([path_radiance(provider, profile, wavenumber, [base], float(angle))[0] for angle in zenith])
    glow_height = np.asarray(
        path_radiance(provider, profile, wavenumber, [float(altitude_m) for altitude_m in height], nadir)
    )
    return AtmosphereSpectra(source.label, wavenumber, zenith, height, (angles, glow), (heights, glow_height))


def _common_range(sources: Sequence[AtmosphereSource], key: str, low: float, high: float) -> tuple[float, float]:
    for source in sources:
        valid = source.provider.declares.valid.get(key, (low, high))
        low, high = max(low, valid[0]), min(high, valid[1])
    return low, high


def _common_wavenumbers(sources: Sequence[AtmosphereSource], range_um: tuple[float, float]) -> Array:
    low, high = _common_range(sources, "wavenumber_cm1", 1e4 / range_um[1], 1e4 / range_um[0])
    natives = (source.provider.declares.native_grid_cm1 for source in sources)
    even = np.arange(np.ceil(low / _STEP_CM1) * _STEP_CM1, high + 1e-9, _STEP_CM1)
    native = next((grid_cm1 for grid_cm1 in natives if grid_cm1 is not None), even)
    grid: Array = native[(native >= low) & (native <= high)]
    if grid.size < 2:
        raise CatalogError(
            f"no common wavenumbers within {range_um[0]:g} to {range_um[1]:g} um; choose others with --range-um"
        )
    return grid


def _common_nodes(sources: Sequence[AtmosphereSource], key: str, wanted: Sequence[float], what: str) -> Array:
    low, high = _common_range(sources, key, -np.inf, np.inf)
    if low > high:
        raise CatalogError(f"the providers have no {what} in common")
    inside = [float(node) for node in wanted if low <= node <= high]
    # Include the ends of a narrow range even if they were not requested.
    if len(inside) < 2:
        inside += [end for end in (low, high) if np.isfinite(end)]
    return np.unique(inside)


def band_means(spectra: AtmosphereSpectra, band_um: tuple[float, float]) -> tuple[Array, Array] | None:
    """Mean transmittance and band path radiance at each angle, over wavenumber.

    Returns
    -------
    tuple of ndarray (Z,), or None where the spectrum does not cover the band
        Transmittance, and radiance in W m-2 sr-1.
    """
    grid = spectra.wavenumber_cm1
    low, high = 1e4 / band_um[1], 1e4 / band_um[0]
    inside = (grid > low) & (grid < high)
    if grid[0] > low or grid[-1] < high or np.count_nonzero(inside) < 2:
        return None
    nodes = np.concatenate(([low], grid[inside], [high]))
    weights = np.zeros_like(nodes)
    weights[1:] += 0.5 * np.diff(nodes)
    weights[:-1] += 0.5 * np.diff(nodes)
    transmittance, radiance = (
        np.array([np.interp(nodes, grid, row) @ weights for row in rows]) for rows in spectra.by_angle
    )
    return transmittance / (high - low), radiance


def compare(first: AtmosphereSpectra, second: AtmosphereSpectra) -> list[str]:
    """Describe the differences of two sources at every wavenumber and in the bands of the HCSS paper."""
    difference = second.by_angle[0] - first.by_angle[0]
    worst = np.unravel_index(int(np.argmax(np.abs(difference))), difference.shape)
    lines = [
        f"{second.label} - {first.label}: transmittance rms {np.sqrt(np.mean(difference**2)):.2e}, largest "
        f"{difference[worst]:+.2e} at {1e4 / first.wavenumber_cm1[worst[1]]:.3f} um, "
        f"{first.zenith_deg[worst[0]]:g} deg"
    ]
    for band in BANDS_UM:
        one, other = band_means(first, band), band_means(second, band)
        if one is None or other is None:
            continue
        lines.append(
            f"  {band[0]:g}-{band[1]:g} um: mean transmittance differs by up to "
            f"{np.max(np.abs(other[0] - one[0])):.2e}, path radiance by up to "
            f"{100 * np.max(np.abs(other[1] / one[1] - 1)):.2f} %"
        )
    return lines


_UNITS = "(W m$^{-2}$ sr$^{-1}$ (cm$^{-1}$)$^{-1}$)"
_QUANTITIES = ("transmittance", f"path radiance {_UNITS}")


def draw(spectra: Sequence[AtmosphereSpectra], path: Path) -> Path:
    """Draw one source, or two and their differences.

    Raises
    ------
    HcssError
        If there are not one or two.
    """
    if not 1 <= len(spectra) <= 2:
        raise HcssError(f"{len(spectra)} sources; allowed: one to plot, or two to compare")
    first, last = spectra[0], spectra[-1]
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 11.0), layout="constrained")
    axes = figure.subplots(3, 2)
    count = first.zenith_deg.size
    # for two sources only the first, middle and last angle, or lines would overlap
    angles = range(count) if len(spectra) == 1 else sorted({0, count // 2, count - 1})
    from_base = f"from {first.height_m[0] / 1e3:g} km to space, by zenith angle"
    labels = [f"{first.zenith_deg[index]:g}°" for index in angles]
    for quantity in (0, 1):
        curves = [[spectrum.by_angle[quantity][index] for index in angles] for spectrum in spectra]
        _panel(axes[0, quantity], first, curves, labels, quantity, from_base, "zenith angle")
        axis = axes[1, quantity]
        if len(spectra) == 1:
            heights = [f"{height / 1e3:g} km" for height in first.height_m]
            title = f"at {first.zenith_deg[0]:g}°, by height of the target"
            _panel(axis, first, [list(first.by_height[quantity])], heights, quantity, title, "target height")
        else:
            changes = [other - one for one, other in zip(*curves, strict=True)]
            _panel(axis, first, [changes], labels, quantity, f"{last.label} minus {first.label}", "zenith angle", True)
        _bands(axes[2, quantity], spectra, quantity)
    figure.suptitle(first.label if len(spectra) == 1 else f"{first.label} (lines) and {last.label} (dashes)")
    with Writing(path, HcssError, "picture") as draft:
        figure.savefig(draft, dpi=110, format=path.suffix.removeprefix(".") or "png")
    return path


def _panel(
    axis: Axes,
    spectra: AtmosphereSpectra,
    curves: Sequence[Sequence[Array]],
    labels: Sequence[str],
    quantity: int,
    title: str,
    legend: str,
    difference: bool = False,
) -> None:
    """Plot one quantity against wavelength: one colour per label, solid for the first source, dashed for the second."""
    from matplotlib import colormaps

    wavelength = 1e4 / spectra.wavenumber_cm1
    for style, curve in zip(("-", "--"), curves, strict=False):
        for index, (label, values) in enumerate(zip(labels, curve, strict=True)):
            colour = colormaps["viridis"](0.92 * index / max(len(labels) - 1, 1))
            axis.plot(wavelength, values, style, color=colour, lw=0.8, label=label if style == "-" else None)
    axis.set_xlabel("wavelength (µm)")
    axis.set_xlim(wavelength[-1], wavelength[0])
    axis.grid(alpha=0.3)
    axis.set_title(title, fontsize=10)
    if difference:
        # "path" is omitted because the label with its unit would exceed the panel height
        axis.set_ylabel("difference of " + _QUANTITIES[quantity].replace("path ", ""))
        axis.axhline(0.0, color="0.6", lw=0.6)
        axis.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
    else:
        axis.set_ylabel(_QUANTITIES[quantity])
        largest = max(float(np.max(values)) for curve in curves for values in curve)
        if quantity == 0:
            axis.set_ylim(0.0, 1.0)
        elif largest > 0:
            # the five decades between the mid-wave window and the 15 um band
            axis.set_yscale("log")
            axis.set_ylim(1e-5 * largest, 1.5 * largest)
    _legend(axis, legend, quantity)


def _bands(axis: Axes, spectra: Sequence[AtmosphereSpectra], quantity: int) -> None:
    drawn = False
    for colour, band in zip(("C0", "C1", "C3"), BANDS_UM, strict=True):
        for style, marker, spectrum in zip(("-", "--"), ("o", "x"), spectra, strict=False):
            means = band_means(spectrum, band)
            if means is None:
                continue
            label = f"{band[0]:g}-{band[1]:g} µm" if style == "-" else None
            axis.plot(spectrum.zenith_deg, means[quantity], style, marker=marker, ms=4, color=colour, label=label)
            drawn = True
    axis.set_xlabel("zenith angle at the surface (deg)")
    axis.set_ylabel(("band-mean transmittance", "band path radiance (W m$^{-2}$ sr$^{-1}$)")[quantity])
    axis.grid(alpha=0.3)
    if not drawn:
        axis.text(0.5, 0.5, "none of the bands is covered", ha="center", transform=axis.transAxes)
        return
    if quantity == 1:
        # The three bands differ by four orders of magnitude.
        axis.set_yscale("log")
    else:
        axis.set_ylim(bottom=0.0)
    _legend(axis, "band", quantity)


def _legend(axis: Axes, title: str, quantity: int) -> None:
    # Both panels of a row share their colours; the legend to the right of them covers no data.
    if quantity == 1:
        position: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
        axis.legend(fontsize=8, title=title, title_fontsize=8, **position)
