"""Figures of cloud optics: efficiencies, single-scattering albedo and phase functions of cloud types."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin import Scenario
from hcss_twin.providers import Array, Catalog, Kind, Microphysics, Optics, OpticsInputs
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.reports.figures import Figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TYPES = ("cumulus", "stratus", "cirrus")
RANGE_UM = (0.3, 14.3)
PHASE_UM = (3.7, 10.8)

_COLOURS = ("tab:blue", "tab:green", "tab:red")
# Ice spheres are large: their forward peak needs more moments than the shipped tables have.
_MOMENTS = 640
_RADII = 4001


@dataclass(frozen=True)
class Efficiencies:
    """Optical properties of one cloud type from one provider, over wavelength.

    Attributes
    ----------
    wavelength_um : ndarray (V,)
        Ascending.
    extinction, scattering, absorption : ndarray (V,)
        Cross sections per projected area of the particles.
    albedo : ndarray (V,)
        Single-scattering albedo.
    """

    wavelength_um: Array
    extinction: Array
    scattering: Array
    absorption: Array
    albedo: Array


def particles(name: str, catalog: Catalog) -> Microphysics:
    """Return the particle properties of one of the paper's cloud types."""
    cloud_type = Scenario.cloud_type(f"paper-{name}", catalog)
    return cloud_type.microphysics.particles(cloud_type.layer.material)


def optics_providers(catalog: Catalog, moments: int | None = None) -> dict[str, Optics]:
    """Return the providers ``bulk`` and ``mie`` (the HCSS paper's spheres) with default parameters.

    Parameters
    ----------
    catalog : Catalog
    moments : int, optional
        Number of phase-function moments of ``mie``, if not the default.
    """
    inputs = OpticsInputs(catalog)
    registry, spheres = Registry.defaults_only(), {} if moments is None else {"moments": moments}
    return {
        name: registry.create(registry.resolve(Kind.OPTICS, name), inputs, parameters)
        for name, parameters in (("bulk", {}), ("mie", spheres))
    }


def efficiencies(provider: Optics, cloud: Microphysics, wavelength_um: Array) -> Efficiencies:
    """Return the efficiencies of one cloud at ascending wavelengths (V,)."""
    optics = provider.single_scattering(cloud, 1e4 / wavelength_um[::-1])
    extinction, share = optics.extinction_m1[::-1] / _projected_area_m1(cloud), optics.albedo[::-1]
    return Efficiencies(wavelength_um, extinction, extinction * share, extinction * (1.0 - share), share)


def _projected_area_m1(cloud: Microphysics) -> float:
    """Return N pi <r^2>, the area of the particles per volume, of the distribution below eq 9."""
    radius_um = np.geomspace(*cloud.radius_range_um, _RADII)
    density = radius_um**cloud.alpha * np.exp(-cloud.b * radius_um**cloud.nu)
    square_um2 = np.trapezoid(density * radius_um**2, radius_um) / np.trapezoid(density, radius_um)
    return float(1e-12 * np.pi * cloud.number_density_m3 * square_um2)


def cloud_optics_figure(catalog: Catalog, types: Sequence[str] = TYPES) -> Figure:
    """Draw efficiencies and albedo at 0.3 to 14.3 um, and phase functions at 3.7 and 10.8 um, of up to three types."""
    providers, in_full = optics_providers(catalog), optics_providers(catalog, _MOMENTS)
    styles: Mapping[str, str] = {"bulk": "-", "mie": ":"}
    figure = Figures.new(11.0, 11.5)
    panels = figure.subplots(3, 2)
    angular = panels[2]
    wavelength = np.linspace(*RANGE_UM, 1401)
    angle = np.linspace(0.0, 180.0, 361)
    for name, colour in zip(types, _COLOURS, strict=False):
        cloud = particles(name, catalog)
        for kind, provider in providers.items():
            line = {"label": name if kind == "bulk" else None, "color": colour, "linestyle": styles[kind]}
            curves = efficiencies(provider, cloud, wavelength)
            spectral = (curves.extinction, curves.scattering, curves.absorption, curves.albedo)
            for axis, values in zip(panels.ravel(), spectral, strict=False):
                axis.plot(wavelength, values, linewidth=1.2, **line)
            # Only ice spheres need many moments, which are slow.
            full = in_full[kind] if cloud.material == "ice" else provider
            for axis, at_um in zip(angular, PHASE_UM, strict=True):
                axis.semilogy(angle, _phase(full, cloud, at_um, angle), linewidth=1.2, **line)
    titles = (
        "(a) extinction efficiency",
        "(b) scattering efficiency",
        "(c) absorption efficiency",
        "(d) single-scattering albedo",
        f"(e) phase function at {PHASE_UM[0]} um",
        f"(f) phase function at {PHASE_UM[1]} um",
    )
    for number, (axis, title) in enumerate(zip(panels.ravel(), titles, strict=True)):
        axis.set_title(title, fontsize=11)
        axis.grid(alpha=0.3)
        if number >= 4:
            axis.set_xlabel("scattering angle (deg)")
            axis.set_xlim(0.0, 180.0)
        else:
            axis.set_xlabel("wavelength (um)")
            axis.set_xlim(*RANGE_UM)
            axis.set_ylim(bottom=0.0)
    panels[0, 0].legend(fontsize=9)
    figure.suptitle(
        "solid: provider bulk (water at 273 K, rough crystals); dotted: provider mie (water at 298 K, ice spheres)",
        fontsize=10,
    )
    return figure


def _phase(provider: Optics, cloud: Microphysics, wavelength_um: float, angle_deg: Array) -> Array:
    moments = provider.single_scattering(cloud, np.array([1e4 / wavelength_um])).moments
    mu = np.cos(np.radians(angle_deg))
    if moments.shape[0] == 2:
        g = float(moments[1, 0])  # Henyey-Greenstein, eq 13
        return (1.0 - g**2) / (1.0 + g**2 - 2.0 * g * mu) ** 1.5
    weights = (2.0 * np.arange(moments.shape[0]) + 1.0) * moments[:, 0]
    values: Array = np.asarray(np.polynomial.legendre.legval(mu, weights), dtype=np.float64)
    return values
