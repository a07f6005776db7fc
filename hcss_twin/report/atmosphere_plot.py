"""Pictures of transmittance providers: the HCSS paper's Figs 15 and 16, and comparisons of two providers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError, HcssError
from hcss_twin.models.atmosphere.path_radiance import path_radiance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.physics.paths import to_space
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereInputs, TransmittanceProvider

if TYPE_CHECKING:
    from matplotlib.axes import Axes


BANDS_UM = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))
"""Bands of the HCSS paper."""

ZENITHS_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)
HEIGHTS_M = (0.0, 1000.0, 3000.0, 6000.0, 10_000.0)
RANGE_UM = (2.5, 14.3)

_STEP_CM1 = 5.0


@dataclass(frozen=True)
class Source:
    """A provider with the atmosphere it belongs to.

    Attributes
    ----------
    label : str
    provider : TransmittanceProvider
    profile : Profile
    """

    label: str
    provider: TransmittanceProvider
    profile: Profile


@dataclass(frozen=True)
class Spectra:
    """What a figure shows of one source.

    Attributes
    ----------
    label : str
    wavenumber_cm1 : ndarray (V,)
    zenith_deg : ndarray (Z,)
        At the lowest height.
    height_m : ndarray (H,)
        At the smallest zenith angle.
    by_angle, by_height : tuple of ndarray
        Transmittance and path radiance, shapes (Z, V) and (H, V); radiance in W m-2 sr-1 (cm-1)-1.
    """

    label: str
    wavenumber_cm1: Array
    zenith_deg: Array
    height_m: Array
    by_angle: tuple[Array, Array]
    by_height: tuple[Array, Array]


def open_source(name: str, profile: str = "us-standard-1976") -> Source:
    """Resolve the name of a provider, a catalog's table, or a table file.

    Raises
    ------
    CatalogError
        If it is none of them.
    ProviderError
        If the provider cannot be constructed.
    """
    from hcss_twin.models.atmosphere.table import TableTransmittance
    from hcss_twin.models.atmosphere.table_file import read_atmosphere_table
    from hcss_twin.models.parameters import TableParameters
    from hcss_twin.providers.registry.registry import Registry
    from hcss_twin.providers.registry.specs import Kind

    catalog = Catalog()
    if name.endswith(".nc") or name in catalog.names("atmospheres", ".nc"):
        own = read_atmosphere_table(catalog.find(name, "atmospheres", ".nc")).profile
        table = TableTransmittance(AtmosphereInputs(own, catalog), TableParameters(file=name))
        return Source(Path(name).stem, table, own)
    registry = Registry.discover()
    names = registry.names(Kind.ATMOSPHERE)
    if name not in names:
        tables = catalog.names("atmospheres", ".nc")
        raise CatalogError(
            f"'{name}' is neither a provider ({', '.join(names)}) nor an atmosphere table ({', '.join(tables)}) nor "
            "a .nc file"
        )
    loaded = load_profile(profile, catalog)
    provider = registry.create(registry.resolve(Kind.ATMOSPHERE, name), AtmosphereInputs(loaded, catalog))
    return Source(name, provider, loaded)


def sample(
    sources: Sequence[Source],
    zenith_deg: Sequence[float] = ZENITHS_DEG,
    height_m: Sequence[float] = HEIGHTS_M,
    range_um: tuple[float, float] = RANGE_UM,
) -> list[Spectra]:
    """Evaluate sources on common wavenumbers, angles and heights that all of them cover.

    Raises
    ------
    CatalogError
        If they have no wavenumber, angle or height in common.
    """
    wavenumber = _common_wavenumbers(sources, range_um)
    zenith = _common_nodes(sources, "view_zenith", zenith_deg, "zenith angle (deg)")
    height = _common_nodes(sources, "target_altitude_m", height_m, "height (m)")
    return [_evaluate(source, wavenumber, zenith, height) for source in sources]


def _evaluate(source: Source, wavenumber: Array, zenith: Array, height: Array) -> Spectra:
    base, nadir = float(height[0]), float(zenith[0])
    provider, profile = source.provider, source.profile
    angles = provider.transmittance(wavenumber, [to_space(base, float(each)) for each in zenith])
    heights = provider.transmittance(wavenumber, [to_space(float(each), nadir) for each in height])
    glow = [path_radiance(provider, profile, wavenumber, [base], float(each))[0] for each in zenith]
    glow_height = path_radiance(provider, profile, wavenumber, [float(each) for each in height], nadir)
    return Spectra(
        source.label, wavenumber, zenith, height, (angles, np.stack(glow)), (heights, np.asarray(glow_height))
    )


def _common_wavenumbers(sources: Sequence[Source], range_um: tuple[float, float]) -> Array:
    low, high = 1e4 / range_um[1], 1e4 / range_um[0]
    for source in sources:
        valid = source.provider.declares.valid.get("wavenumber_cm1", (low, high))
        low, high = max(low, valid[0]), min(high, valid[1])
    native = next(
        (s.provider.declares.native_grid_cm1 for s in sources if s.provider.declares.native_grid_cm1 is not None),
        np.arange(np.ceil(low / _STEP_CM1) * _STEP_CM1, high + 1e-9, _STEP_CM1),
    )
    grid: Array = native[(native >= low) & (native <= high)]
    if grid.size < 2:
        raise CatalogError(
            f"no common wavenumbers within {range_um[0]:g} to {range_um[1]:g} um; choose others with --range-um"
        )
    return grid


def _common_nodes(sources: Sequence[Source], key: str, wanted: Sequence[float], what: str) -> Array:
    low, high = -np.inf, np.inf
    for source in sources:
        valid = source.provider.declares.valid.get(key, (low, high))
        low, high = max(low, valid[0]), min(high, valid[1])
    if low > high:
        raise CatalogError(f"the providers have no {what} in common")
    inside = [float(each) for each in wanted if low <= each <= high]
    # The ends of a narrow range are shown although nobody asked for just them.
    if len(inside) < 2:
        inside += [each for each in (low, high) if np.isfinite(each)]
    return np.unique(inside)


def band_means(spectra: Spectra, band_um: tuple[float, float]) -> tuple[Array, Array] | None:
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


def compare(first: Spectra, second: Spectra) -> list[str]:
    """Differences of two sources in words: at every wavenumber, and in the bands of the HCSS paper."""
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


def draw(spectra: Sequence[Spectra], path: Path) -> Path:
    """Draw one source, or two and their differences.

    Raises
    ------
    HcssError
        If there are not one or two.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if not 1 <= len(spectra) <= 2:
        raise HcssError(f"{len(spectra)} sources; one is drawn, or two are compared")
    figure = Figure(figsize=(12.0, 11.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(3, 2)
    first = spectra[0]
    _lines(axes[0, 0], spectra, 0)
    _lines(axes[0, 1], spectra, 1)
    if len(spectra) == 1:
        _heights(axes[1, 0], first, 0)
        _heights(axes[1, 1], first, 1)
        figure.suptitle(first.label)
    else:
        _differences(axes[1, 0], spectra[0], spectra[1], 0)
        _differences(axes[1, 1], spectra[0], spectra[1], 1)
        figure.suptitle(f"{spectra[0].label} (lines) and {spectra[1].label} (dashes)")
    _bands(axes[2, 0], spectra, 0)
    _bands(axes[2, 1], spectra, 1)
    figure.savefig(path, dpi=110)
    return path


def _colours(count: int) -> list[Any]:
    from matplotlib import colormaps

    return [colormaps["viridis"](0.92 * index / max(count - 1, 1)) for index in range(count)]


_QUANTITIES = ("transmittance", "path radiance (W m$^{-2}$ sr$^{-1}$ (cm$^{-1}$)$^{-1}$)")


def _shown_angles(spectra: Sequence[Spectra]) -> list[int]:
    """All angles of one source; of two only the ends and the middle, or the lines hide each other."""
    count = spectra[0].zenith_deg.size
    return list(range(count)) if len(spectra) == 1 else sorted({0, count // 2, count - 1})


def _lines(axis: Axes, spectra: Sequence[Spectra], quantity: int) -> None:
    chosen = _shown_angles(spectra)
    for colour, index in zip(_colours(len(chosen)), chosen, strict=True):
        for style, each in zip(("-", "--"), spectra, strict=False):
            label = f"{each.zenith_deg[index]:g}°" if style == "-" else None
            wavelength = 1e4 / each.wavenumber_cm1
            axis.plot(wavelength, each.by_angle[quantity][index], style, color=colour, lw=0.8, label=label)
    _spectral_axis(axis, spectra[0], quantity)
    if quantity == 0:
        axis.set_ylim(0.0, 1.0)
    else:
        _logarithmic(axis, max(float(each.by_angle[1].max()) for each in spectra))
    axis.set_title(f"from {spectra[0].height_m[0] / 1e3:g} km to space, by zenith angle", fontsize=10)
    _legend(axis, "zenith angle", quantity)


def _heights(axis: Axes, spectra: Spectra, quantity: int) -> None:
    wavelength = 1e4 / spectra.wavenumber_cm1
    for colour, index in zip(_colours(spectra.height_m.size), range(spectra.height_m.size), strict=True):
        label = f"{spectra.height_m[index] / 1e3:g} km"
        axis.plot(wavelength, spectra.by_height[quantity][index], color=colour, lw=0.8, label=label)
    _spectral_axis(axis, spectra, quantity)
    if quantity == 0:
        axis.set_ylim(0.0, 1.0)
    else:
        _logarithmic(axis, float(spectra.by_height[1].max()))
    axis.set_title(f"at {spectra.zenith_deg[0]:g}°, by height of the target", fontsize=10)
    _legend(axis, "target height", quantity)


def _differences(axis: Axes, first: Spectra, second: Spectra, quantity: int) -> None:
    chosen = _shown_angles((first, second))
    for colour, index in zip(_colours(len(chosen)), chosen, strict=True):
        change = second.by_angle[quantity][index] - first.by_angle[quantity][index]
        label = f"{first.zenith_deg[index]:g}°"
        axis.plot(1e4 / first.wavenumber_cm1, change, color=colour, lw=0.8, label=label)
    axis.axhline(0.0, color="0.6", lw=0.6)
    _spectral_axis(axis, first, quantity)
    # "path" is left out: with the unit the label is as long as the panel is high.
    axis.set_ylabel("difference of " + _QUANTITIES[quantity].replace("path ", ""))
    axis.ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
    axis.set_title(f"{second.label} minus {first.label}", fontsize=10)
    _legend(axis, "zenith angle", quantity)


def _bands(axis: Axes, spectra: Sequence[Spectra], quantity: int) -> None:
    drawn = False
    for colour, band in zip(("C0", "C1", "C3"), BANDS_UM, strict=True):
        for style, marker, each in zip(("-", "--"), ("o", "x"), spectra, strict=False):
            means = band_means(each, band)
            if means is None:
                continue
            label = f"{band[0]:g}-{band[1]:g} µm" if style == "-" else None
            axis.plot(each.zenith_deg, means[quantity], style, marker=marker, ms=4, color=colour, label=label)
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


def _spectral_axis(axis: Axes, spectra: Spectra, quantity: int) -> None:
    axis.set_xlabel("wavelength (µm)")
    axis.set_ylabel(_QUANTITIES[quantity])
    axis.set_xlim(1e4 / spectra.wavenumber_cm1[-1], 1e4 / spectra.wavenumber_cm1[0])
    axis.grid(alpha=0.3)


def _logarithmic(axis: Axes, largest: float) -> None:
    """Show path radiance over the five decades between the mid-wave window and the 15 um band."""
    if largest > 0:
        axis.set_yscale("log")
        axis.set_ylim(1e-5 * largest, 1.5 * largest)


def _legend(axis: Axes, title: str, quantity: int) -> None:
    # Both panels of a row share their colours; beside the right one it hides nothing.
    if quantity == 1:
        axis.legend(
            fontsize=8, title=title, title_fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0
        )
