"""Transmittance of any path, from a provider that supports only paths from an altitude to space.

At each wavenumber -ln T = (sum over layers of air mass x w)^a. The layer amounts w follow from vertical paths to space,
which are reproduced exactly. The exponent a follows from a vertical and a slant path at the surface: 1 for weak
absorption, 0.5 for a strong Lorentz line, where absorption is saturated at the line's centre and grows only in its
wings. Products of leg transmittances would ignore this saturation and have larger errors.

Errors of band means are a few percent for paths that go up and down again; a provider for any path is better. If the
provider supports the path from the sun down to a target and up again, its transmittance is used; the power law
extrapolates it if the sun is too low.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.errors import ProviderError
from hcss_twin.physics.paths import SPACE, Leg, LegSums, Path, to_space
from hcss_twin.physics.profile import Profile, airmass_of_legs
from hcss_twin.providers import AtmosphereDeclaration, TransmittanceProvider

_SLANT_DEG = 60.0
_MIN_DEPTH, _MAX_DEPTH = 1e-12, 700.0
_EXPONENTS = (0.2, 1.0)
"""Range of a: below 0.5 for tables that fall off more slowly than a strong Lorentz line, up to weak absorption."""

_MAX_SUN_PATHS = 512
"""Paths from the sun to a target and up again held in memory: columns with the same cloud share them."""

_SURELY_WITHIN = 0.99
"""Fraction of the maximum air mass below which a path must have been rejected for another reason."""


class PowerLawGas:
    """Transmittance provider for any path, fitted to one for paths to space.

    Parameters
    ----------
    provider : TransmittanceProvider
        AtmosphereDeclaration ``legs = "to_space"``.
    profile : Profile
        Its levels are the layer boundaries; targets outside the provider's range are not requested.
    """

    def __init__(self, provider: TransmittanceProvider, profile: Profile) -> None:
        self.declares: AtmosphereDeclaration = provider.declares
        self._provider = provider
        self._profile = profile
        low, high = provider.declares.valid.get("target_altitude_m", (0.0, float(profile.altitude_m[-1])))
        levels = profile.altitude_m
        self._targets = [float(z) for z in levels[:-1] if low <= z <= high]
        self._known: dict[bytes, tuple[Array, Array]] = {}
        self._airmass = LegSums(levels.size - 1, self._add_airmass)
        self._own_of = cached_method(self._ask, _MAX_SUN_PATHS)

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of composite paths."""
        amount, exponent = self._fit(wavenumber_cm1)
        result: Array = np.exp(-((self._airmass.of(paths) @ amount) ** exponent))
        for row, path in enumerate(paths):
            transmittance = self._own(wavenumber_cm1, path)
            if transmittance is not None:
                result[row] = transmittance
        return result

    def _add_airmass(self, legs: Iterable[Leg], known: dict[Leg, Array]) -> None:
        """Compute the air masses (L,) of legs and store them."""
        new = list(legs)
        known.update(zip(new, airmass_of_legs(self._profile, new), strict=True))

    def _own(self, wavenumber_cm1: Array, path: Path) -> Array | None:
        """Return the provider's transmittance (V,) from the sun down to a target and up again; None for other paths.

        These need not be consistent with the power law, because no emission is weighted with their differences
        (``Air`` ends such legs at the highest level).
        """
        if sum(leg.upper_m == SPACE for leg in path.legs) != 2:
            return None
        legs = joined(path)
        if len(legs) != 2 or any(leg.upper_m != SPACE or leg.lower_m != legs[0].lower_m for leg in legs):
            return None
        return self._own_of(wavenumber_cm1.tobytes(), legs)

    def _ask(self, wavenumbers: bytes, legs: tuple[Leg, ...]) -> Array | None:
        wavenumber = np.frombuffer(wavenumbers, dtype=np.float64)
        try:
            transmittance: Array = self._provider.transmittance(wavenumber, [Path(legs)])[0]
        except ProviderError:
            return self._beyond(wavenumber, legs)
        return transmittance

    def _beyond(self, wavenumber_cm1: Array, legs: tuple[Leg, ...]) -> Array | None:
        """Extrapolate the transmittance of the longest path to a larger air mass by the power law; return (V,).

        The fit alone would have errors of some percent, and the light of a low sun would jump where clouds rise out of
        that range. None if the provider rejects the path for another reason.
        """
        target, angles = legs[0].lower_m, self.declares.valid.get("view_zenith")
        if angles is None:
            return None
        mass = float(np.sum(self._profile.mean_airmass(target, np.array([leg.zenith_deg for leg in legs]))))
        longest = float(self._profile.mean_airmass(target, np.array([angles[1]]))[0])
        # The provider's profile may differ a little from this one.
        if mass < _SURELY_WITHIN * longest:
            return None
        try:
            depth = self._depth(wavenumber_cm1, [to_space(target, angles[1])])[0]
        except ProviderError:
            return None
        exponent = self._fit(wavenumber_cm1)[1]
        return np.asarray(np.exp(-depth * (mass / longest) ** exponent))

    def _fit(self, wavenumber_cm1: Array) -> tuple[Array, Array]:
        """Return layer amounts (L, V) and exponents (V,)."""
        key = wavenumber_cm1.tobytes()
        if key not in self._known:
            vertical = self._depth(wavenumber_cm1, [to_space(z, 0.0) for z in self._targets])
            slant = self._depth(wavenumber_cm1, [to_space(self._targets[0], _SLANT_DEG)])[0]
            mass = float(self._profile.mean_airmass(self._targets[0], np.array([_SLANT_DEG]))[0])
            exponent = np.clip(np.log(slant / vertical[0]) / np.log(mass), *_EXPONENTS)
            above = vertical ** (1.0 / exponent)
            # Amounts decrease with height, except for rounding in a table.
            above = np.minimum.accumulate(above, axis=0)
            amount = np.zeros((self._profile.altitude_m.size - 1, wavenumber_cm1.size))
            amount[: len(self._targets)] = above - np.concatenate((above[1:], np.zeros_like(above[:1])))
            self._known[key] = amount, exponent
        return self._known[key]

    def _depth(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        transmittance = self._provider.transmittance(wavenumber_cm1, paths)
        depth = -np.log(np.maximum(transmittance, np.exp(-_MAX_DEPTH)))
        return np.asarray(np.maximum(depth, _MIN_DEPTH))


def joined(path: Path) -> tuple[Leg, ...]:
    """Return the legs of a path, with consecutive legs in the same direction merged."""
    legs: list[Leg] = []
    for leg in sorted(path.legs, key=lambda leg: (leg.zenith_deg, leg.lower_m)):
        if legs and legs[-1].zenith_deg == leg.zenith_deg and legs[-1].upper_m == leg.lower_m:
            legs[-1] = Leg(legs[-1].lower_m, leg.upper_m, leg.zenith_deg)
        elif leg.lower_m < leg.upper_m:
            legs.append(leg)
    return tuple(legs)
