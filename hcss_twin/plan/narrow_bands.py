"""Warnings about bands that are narrower than the spectral knowledge of the atmosphere."""

from __future__ import annotations

from collections.abc import Iterator

from hcss_twin.models.radiance.spectral_grid import SpectralBand
from hcss_twin.plan.assembly import Assembly
from hcss_twin.providers.registry.specs import Kind

NARROW_CM1 = 60.0
STRUCTURED_CM1 = ((650.0, 760.0), (2200.0, 2390.0))
"""Channels narrower than this, in these ranges, depend on the structure inside RRTMGP's bands, which is LOWTRAN7's."""


def narrow_notes(assembly: Assembly, coefficients: str | None) -> Iterator[str]:
    """Yield a warning for each band below the resolution, or in the structure inside RRTMGP's bands.

    Parameters
    ----------
    assembly : Assembly
    coefficients : str or None
        Name of the coefficients of the band model.
    """
    resolution = assembly.transmittance.declares.resolution_cm1
    atmosphere = assembly.entries[str(Kind.ATMOSPHERE)].name
    for band in assembly.bands:
        if band.width_cm1 < resolution:
            yield (
                f"band '{band.name}' is {band.width_cm1:.3g} cm-1 wide, but the atmosphere '{atmosphere}' knows means "
                f"over {resolution:g} cm-1: lines within it are not resolved, whatever the accuracy"
            )
        if coefficients == "rrtmgp" and _in_structure(band):
            yield (
                f"band '{band.name}' is {band.width_cm1:.3g} cm-1 wide, but coefficients 'rrtmgp' are fitted to "
                f"whole RRTMGP bands: channels narrower than about {NARROW_CM1:g} cm-1 near 650-760 and "
                "2200-2390 cm-1 may be wrong by 1 to 4 K"
            )


def _in_structure(band: SpectralBand) -> bool:
    low, high = 1e4 / band.upper_um, 1e4 / band.lower_um
    return band.width_cm1 < NARROW_CM1 and any(low < last and high > first for first, last in STRUCTURED_CM1)
