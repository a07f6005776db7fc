"""Path radiance that a provider knows but the radiance model does not use, and how much that changes a clear pixel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.path_radiance import emission_of_layers
from hcss_twin.physics.paths import SPACE, Path, to_space
from hcss_twin.plan.assembly import Assembly
from hcss_twin.plan.few_columns import FewColumns, few_columns
from hcss_twin.providers import Sun
from hcss_twin.providers.registry.guard import was_called
from hcss_twin.providers.registry.specs import Kind

WAVENUMBERS = 48
"""Number of wavenumbers of each band for path radiance, which varies more than the sum of all terms."""


def unused_path_radiance(assembly: Assembly, sun: Sun | None, accuracy: float) -> tuple[str, ...]:
    """Return a note if the provider's own path radiance differs from the one that the radiance model derives.

    An imported MODTRAN or libRadtran run has path radiance of its own. Models that combine any paths derive it from
    transmittances and the temperatures of the profile instead, as only this closes the energy balance.

    Parameters
    ----------
    assembly : Assembly
        Its radiance model has been called before, so that it is known which members of the provider it uses.
    sun : Sun or None
        Of the darkest frame.
    accuracy : float
        Relative to the clear radiance of a band; smaller differences are not reported.
    """
    provider = assembly.transmittance
    if not hasattr(provider, "path_radiance") or was_called(provider, "path_radiance"):
        return ()
    columns = few_columns(assembly, WAVENUMBERS)
    wavenumber, ground_m = columns.wavenumber_cm1, float(assembly.profile.altitude_m[0])
    names = [f"'{assembly.entries[str(kind)].name}'" for kind in (Kind.ATMOSPHERE, Kind.RADIANCE)]
    said = "the radiance model {1} does not use the path radiance of the atmosphere {0}: ".format(*names)
    try:
        provided = provider.path_radiance(wavenumber, [to_space(ground_m, assembly.view.zenith_deg)])[0]
    except ProviderError as error:
        return (f"{said}the difference is unknown ({error})",)
    more = columns.weights_cm1 @ (provided - derived_path_radiance(assembly, wavenumber, ground_m))
    if np.all(np.abs(more) < 0.5 * accuracy * _clear(assembly, few_columns(assembly), sun)):
        return ()  # the plan has computed these few columns before
    clear = _clear(assembly, columns, sun)
    if provider.declares.legs != "to_space":
        layers = emission_of_layers(provider, assembly.profile, wavenumber, ground_m, assembly.view.zenith_deg)
        if np.all(np.abs(columns.weights_cm1 @ (provided - layers)) <= accuracy * clear):
            return ()  # the emission of the same air, with one temperature for each layer
    shares = np.divide(more, clear, out=np.zeros_like(more), where=clear > 0.0)
    changes = [
        f"{100.0 * share:+.2g} % in band '{band.name}'"
        for band, share in zip(assembly.bands, shares, strict=True)
        if abs(share) > accuracy
    ]
    return (f"{said}with it, clear radiance would change by {', '.join(changes)}",) if changes else ()


def _clear(assembly: Assembly, columns: FewColumns, sun: Sun | None) -> Array:
    """Return the radiance (B,) of a clear pixel."""
    clear: Array = replace(columns, clear=True, thickness_m=columns.thickness_m[:0]).total(assembly, sun)[0]
    return clear


def derived_path_radiance(assembly: Assembly, wavenumber_cm1: Array, ground_m: float) -> Array:
    """Return the emission (V,) of the air above a clear sea, from transmittances and the profile's temperatures."""
    from hcss_twin.models.radiance.physical.air import Air
    from hcss_twin.models.radiance.physical.power_law_gas import PowerLawGas

    gas = assembly.transmittance
    if gas.declares.legs == "to_space":
        gas = PowerLawGas(gas, assembly.profile)
    memory = assembly.air_over_field.of(assembly.view).memory
    air = Air(gas, assembly.profile, wavenumber_cm1, memory=memory)
    front, transparent = air.crossed([[Path()]]), np.ones((1, wavenumber_cm1.size))
    leg = air.leg(front, transparent, (assembly.view.zenith_deg,), (ground_m,), (SPACE,), downward=True)
    emission: Array = leg.emission[0]
    return emission
