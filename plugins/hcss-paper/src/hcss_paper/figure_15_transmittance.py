"""Figs 15 and 16: transmittance from cloud and from sea to the detector, over wavelength and angle."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from hcss_paper.figure_base import blank
from hcss_paper.inputs import in_words, published
from hcss_paper.reproduction import Check, Drawing, Reproduction, Row, judged
from hcss_twin import Scenario, make_plan
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.providers import Array, AtmosphereInputs, Catalog, Kind, TransmittanceProvider, to_space
from hcss_twin.providers.registry.registry import Registry

if TYPE_CHECKING:
    from matplotlib.figure import Figure


CLOUD_M = 6000.0
STARTS_M = {"cloud": CLOUD_M, "sea": 0.0}
RANGE_UM = (1.0, 14.0)
"""The shipped table of the Fortran code ends at 1 um, the band model at 0.7 um."""

BANDS_UM = ((2.7, 3.0), (3.0, 5.0), (8.0, 14.0))
STEP_CM1 = 5.0

LARGEST_MEAN_OFF = 2e-3
"""Largest difference of band means from the LOWTRAN7 Fortran, whose profile has different levels."""

LARGEST_RMS = 5e-3

_TABLE = "us-standard-1976-lowtran7"
_INPUTS = in_words(f"cloud at {CLOUD_M / 1e3:g} km: not stated, fitted to Tables II and IV; no aerosol: not stated")
_NOTES = (
    f"The range starts at {RANGE_UM[0]:g} um: the paper's axis begins at 0, where transmittance is undefined.",
    "The angle is the zenith angle at the surface, at which the sea is still visible at 70 deg. According to the text, "
    "transmittance reaches 0 at about 70 deg, which is true for the angle at the satellite.",
    "MODTRAN, which the paper used, needs a licence; the shipped table was computed with LOWTRAN7, its predecessor, "
    "for the same atmosphere. The corrected physics uses the same transmittances.",
)


def views_deg() -> tuple[float, ...]:
    """Return the paper's view zenith angles."""
    return tuple(float(view) for view in published()["view_zenith_deg"])


@lru_cache(maxsize=2)
def spectra(table: str | None = None) -> tuple[Array, dict[str, Array]]:
    """Return ascending wavelengths (V,) in um, and transmittance (views, V) from cloud and from sea to space.

    Parameters
    ----------
    table : str, optional
        Name of an atmosphere table; by default the air of scenario ``baseline``.
    """
    provider: TransmittanceProvider
    if table is None:
        provider = make_plan(Scenario.load("baseline", {"frames.count": 1})).assembly.transmittance
    else:
        catalog = Catalog()
        profile = AtmosphereTable.read(catalog.find(table, "atmospheres", ".nc")).profile
        registry = Registry.defaults_only()
        entry = registry.resolve(Kind.ATMOSPHERE, "table")
        provider = registry.create(entry, AtmosphereInputs(profile, catalog), {"file": table})
    low, high = 1e4 / RANGE_UM[1], 1e4 / RANGE_UM[0]
    wavenumber = np.arange(np.ceil(low / STEP_CM1) * STEP_CM1, high + 1e-9, STEP_CM1)
    found = {}
    for name, start in STARTS_M.items():
        paths = [to_space(start, view) for view in views_deg()]
        found[name] = provider.transmittance(wavenumber, paths)[:, ::-1]
    return 1e4 / wavenumber[::-1], found


def mean_over(wavelength_um: Array, values: Array, band_um: tuple[float, float]) -> Array:
    """Return means (views,) over wavelength of spectra (views, V)."""
    inside = (wavelength_um > band_um[0]) & (wavelength_um < band_um[1])
    places = np.concatenate(([band_um[0]], wavelength_um[inside], [band_um[1]]))
    means = [np.trapezoid(np.interp(places, wavelength_um, row), places) for row in values]
    result: Array = np.array(means) / (band_um[1] - band_um[0])
    return result


def figure_15(seed: int) -> Reproduction:
    """Return the spectra at 0 to 70 degrees."""
    del seed  # no random numbers are used
    wavelength, found = spectra()
    reference = spectra(_TABLE)[1]
    rows = [
        Row(f"{start}, {band[0]:g}-{band[1]:g} um, {view:g} deg, mean", "1", None, float(mean))
        for start, values in found.items()
        for band in BANDS_UM
        for view, mean in zip(views_deg(), mean_over(wavelength, values, band), strict=True)
    ]
    return judged(
        rows,
        spectral_checks(found, reference),
        holds="Transmittance falls with the angle at every wavelength, is higher from the cloud than from the sea, "
        "and agrees with LOWTRAN7; the paper prints no numbers.",
        fails="A spectrum violates a law of transmittance, or differs from LOWTRAN7's.",
        chosen=_INPUTS,
        notes=_NOTES,
        drawings=(
            Drawing(
                "Transmittance to the detector, by zenith angle",
                _drawn_spectra(wavelength, found),
                "Two panels of eight spectra: windows at 3.5-4.1 and 8-13 um, dark bands at 2.7, 4.3 and 6.3 um, all "
                "lower with a larger angle; from the cloud the water bands are transparent.",
            ),
        ),
    )


def spectral_checks(found: dict[str, Array], reference: dict[str, Array]) -> list[Check]:
    """Check spectra (views, V) from cloud and from sea, and compare them with LOWTRAN7's."""
    every = np.stack([found["cloud"], found["sea"]])
    rise = float(np.max(np.diff(every, axis=1)))
    under = float(np.max(found["sea"] - found["cloud"]))
    rms = max(float(np.sqrt(np.mean((found[name] - reference[name]) ** 2))) for name in STARTS_M)
    return [
        Check(f"between 0 and 1: {every.min():.1e} to {every.max():.5f}", bool(every.min() >= 0 and every.max() <= 1)),
        Check(
            f"falls from 0 to 70 deg at every wavelength; largest rise {rise:.1e}, at most 1e-9",
            rise <= 1e-9,
            "section V-A",
        ),
        Check(
            f"transmittance from the cloud is not below that from the sea; largest deficit {under:.1e}, at most 1e-9",
            under <= 1e-9,
        ),
        Check(f"against the LOWTRAN7 Fortran: rms {rms:.1e}, at most {LARGEST_RMS:g}", rms <= LARGEST_RMS),
    ]


def figure_16(seed: int) -> Reproduction:
    """Return means over the spectrum at 0 to 70 degrees."""
    del seed  # no random numbers are used
    wavelength, found = spectra()
    reference = spectra(_TABLE)[1]
    means = {name: mean_over(wavelength, values, RANGE_UM) for name, values in found.items()}
    others = {name: mean_over(wavelength, values, RANGE_UM) for name, values in reference.items()}
    rows = [
        Row(f"{name}, {view:g} deg, mean over {RANGE_UM[0]:g}-{RANGE_UM[1]:g} um", "1", None, float(mean))
        for name, values in means.items()
        for view, mean in zip(views_deg(), values, strict=True)
    ]
    return judged(
        rows,
        mean_checks(means, others),
        holds="The mean falls with the angle, most steeply to 70 degrees, and is higher from the cloud; the paper "
        "prints no numbers.",
        fails="The mean does not behave as the text states.",
        chosen=_INPUTS,
        notes=(f"Mean over wavelength, {RANGE_UM[0]:g} to {RANGE_UM[1]:g} um.", *_NOTES[1:]),
        drawings=(
            Drawing(
                "Mean transmittance to the detector",
                _drawn_means(wavelength, found, means),
                "Lines that fall with the angle, slowly at first and steeply to 70 degrees; those from the cloud are "
                "above those from the sea.",
            ),
        ),
    )


def mean_checks(means: dict[str, Array], reference: dict[str, Array]) -> list[Check]:
    """Check means (views,) from cloud and from sea, and compare them with LOWTRAN7's."""
    falls = all(np.all(np.diff(values) < 0) for values in means.values())
    steepest = all(int(np.argmin(np.diff(values))) == len(values) - 2 for values in means.values())
    off = max(float(np.max(np.abs(means[name] - reference[name]))) for name in means)
    return [
        Check("falls with every step of the angle", bool(falls), "section V-A"),
        Check("falls most from 60 to 70 deg", steepest),
        Check(
            "transmittance from the cloud is above that from the sea at every angle",
            bool(np.all(means["cloud"] > means["sea"])),
        ),
        Check(
            f"against the LOWTRAN7 Fortran: difference {off:.1e}, at most {LARGEST_MEAN_OFF:g}", off <= LARGEST_MEAN_OFF
        ),
    ]


def _drawn_spectra(wavelength: Array, found: dict[str, Array]) -> Figure:
    from matplotlib import colormaps

    figure = blank(9.6, 6.4)
    axes = figure.subplots(2, 1, sharex=True)
    titles = (f"(a) from the cloud at {CLOUD_M / 1e3:g} km", "(b) from the sea")
    for axis, title, values in zip(axes, titles, found.values(), strict=True):
        for index, view in enumerate(views_deg()):
            colour = colormaps["viridis"](0.92 * index / (len(views_deg()) - 1))
            axis.plot(wavelength, values[index], color=colour, lw=0.8, label=f"{view:g}°")
        axis.set(ylabel="transmittance", ylim=(0.0, 1.0), xlim=(0.0, RANGE_UM[1]), title=title)
        axis.grid(alpha=0.3)
    axes[1].set_xlabel("wavelength (um)")
    axes[0].legend(title="zenith angle", loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8, title_fontsize=8)
    return figure


def _drawn_means(wavelength: Array, found: dict[str, Array], means: dict[str, Array]) -> Figure:
    figure = blank(9.6, 4.2)
    left, right = figure.subplots(1, 2, sharey=True)
    for name, style in (("cloud", "o-"), ("sea", "s--")):
        left.plot(views_deg(), means[name], style, color="k", label=f"from the {name}")
        for colour, band in zip(("C0", "C1", "C3"), BANDS_UM, strict=True):
            values = mean_over(wavelength, found[name], band)
            right.plot(views_deg(), values, style, color=colour, ms=4, label=f"{name}, {band[0]:g}-{band[1]:g} um")
    left.set(title=f"mean over {RANGE_UM[0]:g}-{RANGE_UM[1]:g} um", ylabel="mean transmittance", ylim=(0.0, 1.0))
    right.set_title("in the paper's bands")
    for axis in (left, right):
        axis.set_xlabel("zenith angle (deg)")
        axis.grid(alpha=0.3)
    left.legend(fontsize=8)
    right.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure
