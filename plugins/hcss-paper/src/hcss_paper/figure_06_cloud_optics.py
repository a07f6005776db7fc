"""Fig 6: optical properties of three cloud types over wavelength."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hcss_paper.cloud_optics import (
    RANGE_UM,
    TYPES,
    Efficiencies,
    cloud_optics_figure,
    efficiencies,
    optics_providers,
    particles,
)
from hcss_paper.figure_base import blank
from hcss_paper.inputs import in_words
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_twin.providers import Catalog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


WAVELENGTHS_UM = (0.55, 2.85, 3.0, 3.7, 4.0, 6.1, 8.5, 10.8, 12.0)
"""Wavelengths of the table rows."""

DIPS_UM = {"cumulus": (2.7, 3.1), "stratus": (2.7, 3.1), "cirrus": (2.7, 3.2)}
"""Range of the lowest albedo; absorption of liquid water peaks at 2.95 um, that of ice at 2.85 to 3.1 um."""

# Particles above 10 um are much larger than the wavelength: the extinction efficiency is slightly above 2 (edge
# effects add about x^(-2/3), x = 2 pi r / wavelength).
_TWICE = (1.95, 2.15)
_SHORTEST_UM = 0.6


def figure_6(seed: int) -> Reproduction:
    """Return efficiencies and albedo from Mie theory and from the corrected optics."""
    del seed  # no random numbers are used
    catalog = Catalog()
    providers = optics_providers(catalog)
    wavelength = np.linspace(*RANGE_UM, 1401)
    clouds = {name: particles(name, catalog) for name in TYPES}
    spheres = {name: efficiencies(providers["mie"], cloud, wavelength) for name, cloud in clouds.items()}
    crystals = {name: efficiencies(providers["bulk"], cloud, wavelength) for name, cloud in clouds.items()}
    rows: list[Row] = []
    checks: list[Check] = []
    for name in TYPES:
        for at_um in WAVELENGTHS_UM:
            values = [float(np.interp(at_um, wavelength, found[name].albedo)) for found in (spheres, crystals)]
            rows.append(Row(f"{name}, single-scattering albedo at {at_um:g} um", "1", None, *values))
        checks += checks_of(name, spheres[name])
    return judged(
        rows,
        checks,
        holds="The efficiencies obey the laws of scattering; the paper prints no numbers.",
        fails="An efficiency violates a law of scattering.",
        chosen=in_words(
            "particles: maritime cumulus and stratus of OPAC, cirrus with effective radius 30 um and variance .1; the "
            "paper gives the form of n(r) without numbers",
            "refractive indices: Hale and Querry (water), Warren and Brandt (ice); not stated",
        ),
        notes=(
            f"The range starts at {RANGE_UM[0]:g} um, the shortest wavelength of the refractive indices in the "
            "catalog.",
            "Physical: temperature-dependent water, and rough ice crystals instead of the paper's ice spheres.",
        ),
        drawings=(
            Drawing(
                "Efficiencies and albedo of spheres, as in Fig 6; dotted: physical",
                _drawn(spheres, crystals),
                "Three panels, cumulus, stratus and cirrus: extinction starts near 2; the albedo is near 1 below 2.5 "
                "um and dips at 3 and 6 um and beyond 10 um.",
            ),
            Drawing(
                "The same quantities by property, and phase functions",
                cloud_optics_figure(catalog),
                "Six panels: three efficiencies, albedo, and phase functions at 3.7 and 10.8 um with a forward peak.",
            ),
        ),
    )


def checks_of(name: str, found: Efficiencies) -> tuple[Check, ...]:
    """Return the checks of the efficiencies of one cloud type, which hold for any particles."""
    short = found.extinction[found.wavelength_um <= _SHORTEST_UM]
    low, high = DIPS_UM[name]
    near = (found.wavelength_um > 2.3) & (found.wavelength_um < 3.6)
    dip_um = float(found.wavelength_um[near][np.argmin(found.albedo[near])])
    dip = float(found.albedo[near].min())
    visible = float(found.albedo[found.wavelength_um < 1.0].min())
    infrared = (found.wavelength_um >= 8.0) & (found.wavelength_um <= 14.0)
    absorbed = float(np.mean(1.0 - found.albedo[infrared]))
    # Half of the extinction of a large particle is diffraction, which is scattering.
    return (
        Check(
            f"{name}: extinction efficiency below {_SHORTEST_UM} um {short.min():.3f} to {short.max():.3f}, within "
            f"{_TWICE[0]} and {_TWICE[1]}",
            bool(_TWICE[0] <= short.min() and short.max() <= _TWICE[1]),
        ),
        Check(
            f"{name}: lowest albedo at {dip_um:.2f} um in the first water band, between {low} and {high} um; "
            f"{dip:.2f}, between .4 and .75",
            low <= dip_um <= high and 0.4 <= dip <= 0.75,
        ),
        Check(f"{name}: albedo below 1 um at least {visible:.5f}, above .999", 0.999 < visible <= 1.0),
        Check(
            f"{name}: absorbs strongly in the infrared, {absorbed:.2f} of the extinction in 8-14 um, at least .2",
            absorbed >= 0.2,
            "section IV-D",
        ),
    )


def _drawn(spheres: dict[str, Efficiencies], crystals: dict[str, Efficiencies]) -> Figure:
    figure = blank(11.0, 4.0)
    for letter, axis, name in zip("abc", figure.subplots(1, 3, sharey=True), TYPES, strict=True):
        for found, style in ((crystals[name], ":"), (spheres[name], "-")):
            for label, values, colour in (
                ("Q$_{ext}$", found.extinction, "k"),
                ("Q$_{sca}$", found.scattering, "C0"),
                ("Q$_{abs}$", found.absorption, "C3"),
                ("ω$_0$", found.albedo, "C2"),
            ):
                shown = label if style == "-" else None
                axis.plot(found.wavelength_um, values, style, color=colour, lw=1.1, label=shown)
        axis.set(xlabel="wavelength (um)", xlim=(0.0, 14.0), title=f"({letter}) {name}")
        axis.set_ylim(bottom=0.0)
        axis.grid(alpha=0.3)
    figure.axes[0].legend(fontsize=9, loc="lower right")
    return figure
