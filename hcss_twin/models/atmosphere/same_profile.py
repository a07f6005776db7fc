"""Test whether two profiles describe the same air, for providers that were computed for one profile."""

from __future__ import annotations

import numpy as np

from hcss_twin.physics.profile import Profile

TOP_M = 20_000.0
"""Altitude below which profiles are compared: the air above it changes no band seen from space by .1 %."""

KELVIN, PRESSURE, GAS = 0.3, 0.005, 0.02
"""Allowed differences of temperature, and relative ones of pressure and of mixing ratios: the rounding of printed
tables, and other levels of the same air."""


def difference(given: Profile, of_provider: Profile) -> str:
    """Return how a profile differs from that of a provider; empty if both describe the same air.

    Compared are pressure, temperature and each gas that both state, at the levels of both. A gas that ``given`` has
    from a model atmosphere, as its file lacks it, is not stated.
    """
    if given is of_provider:
        return ""
    top = min(float(given.altitude_m[-1]), float(of_provider.altitude_m[-1]))
    if top < TOP_M:
        return f"it ends at {top:g} m; allowed: {TOP_M:g} m or higher"
    levels = np.union1d(given.altitude_m, of_provider.altitude_m)
    given_at_levels, provider_at_levels = (
        profile.resampled(levels[levels <= TOP_M]) for profile in (given, of_provider)
    )
    kelvin = given_at_levels.temperature_K - provider_at_levels.temperature_K
    differences = [("temperature", kelvin, KELVIN, "K", 1.0)]
    differences.append(
        ("pressure", given_at_levels.pressure_Pa / provider_at_levels.pressure_Pa - 1.0, PRESSURE, "%", 100.0)
    )
    for gas in (gas for gas in of_provider.mixing_ratio if gas in stated_gases(given)):
        ratio, reference = given_at_levels.mixing_ratio[gas], provider_at_levels.mixing_ratio[gas]
        scale = np.where(reference > 0.0, reference, np.maximum(ratio, 1e-30))
        differences.append((gas.upper(), (ratio - reference) / scale, GAS, "%", 100.0))
    texts = []
    for name, values, allowed, unit, factor in differences:
        worst = int(np.argmax(np.abs(values)))
        if abs(values[worst]) > allowed:
            size = f"{factor * values[worst]:+.3g} {unit} at {given_at_levels.altitude_m[worst]:g} m"
            texts.append(f"{name} differs by {size} (allowed: {factor * allowed:g} {unit})")
    return ", ".join(texts)


def stated_gases(profile: Profile) -> tuple[str, ...]:
    """Return the gases of a profile that are not filled in: all of a model atmosphere, and those of a user's file.

    A file always has the water vapour.
    """
    filled = frozenset() if "h2o" in profile.model_gases else profile.model_gases
    return tuple(gas for gas in profile.mixing_ratio if gas not in filled)


def unstated(given: Profile, of_provider: Profile) -> tuple[str, ...]:
    """Return the gases that a profile states and that of a provider does not, so that they cannot be compared."""
    return tuple(gas for gas in stated_gases(given) if gas not in of_provider.mixing_ratio)
