"""The provider, imported only when a scenario selects it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcss_lowtran7.build import build
from hcss_lowtran7.deck import RADIANCE as RADIANCE_RUN
from hcss_lowtran7.deck import SLANT, TO_SPACE, Air, Haze, Ray, deck
from hcss_lowtran7.deck import TRANSMITTANCE as TRANSMITTANCE_RUN
from hcss_lowtran7.levels import missing_gases, temperature_departure_K
from hcss_lowtran7.model_air import model_air
from hcss_lowtran7.parameters import Lowtran7Parameters
from hcss_lowtran7.program import RADIANCE, STEP_CM1, TRANSMITTANCE, Job, spectra
from hcss_lowtran7.source import find_source
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs, Leg, Path, ProviderError, local_zenith_deg

Array = NDArray[np.float64]

FIRST_CM1, LAST_CM1 = 100.0, 30000.0

_IHAZE = {"none": 0, "rural": 1, "maritime": 4, "urban": 5, "tropospheric": 6}
_ISEASN = {None: 0, "spring-summer": 1, "fall-winter": 2}


@dataclass(frozen=True)
class _Spectrum:
    """What is known of one path: values at the nodes ``first``, ``first + 1``, ..."""

    first: int
    values: Array

    def covers(self, first: int, last: int) -> bool:
        return self.first <= first and last <= self.first + self.values.size - 1


class Lowtran7:
    """Transmittance and thermal path radiance computed with the LOWTRAN7 Fortran.

    Parameters
    ----------
    inputs : AtmosphereInputs
        The profile: LOWTRAN7's own atmosphere where name and values are those of an AFGL one, else
        handed over level by level.
    parameters : Lowtran7Parameters
        Aerosol.

    Raises
    ------
    ProviderError
        If the source of LOWTRAN7 is not installed, or cannot be compiled or run.

    Notes
    -----
    Band model of 20 cm-1 on a grid of 5 cm-1 (Kneizys et al., AFGL-TR-88-0177). Rays are refracted
    from the zenith angle at their lower end, which follows from that at the surface by straight lines;
    the radius of the Earth is hcss_twin's for every atmosphere. Absorber amounts of all legs are added
    before the band functions are applied.
    """

    def __init__(self, inputs: AtmosphereInputs, parameters: Lowtran7Parameters) -> None:
        self._program = build(find_source(), parameters.precision)
        haze = Haze(_IHAZE[parameters.aerosol], _ISEASN[parameters.season], parameters.visibility_km or 0.0)
        self._air = model_air(self._program, inputs.profile, haze)
        levels = self._air.levels
        self._top_m = 100_000.0 if levels is None else 1000.0 * float(levels.altitude_km[-1])
        self._known: dict[tuple[int, tuple[Leg, ...]], _Spectrum] = {}
        self.declares = AtmosphereDeclaration(
            valid={"wavenumber_cm1": (FIRST_CM1, LAST_CM1)},
            native_grid_cm1=np.arange(FIRST_CM1, LAST_CM1 + STEP_CM1 / 2, STEP_CM1),
            resolution_cm1=20.0,
            notes=_notes(self._air, inputs, parameters),
        )

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of composite paths, linear between nodes of 5 cm-1.

        Raises
        ------
        ProviderError
            If a wavenumber lies outside 100 to 30 000 cm-1, or LOWTRAN7 cannot trace a path.
        """
        # LOWTRAN7 is single precision: saturated sums can leave [0, 1] in the last digit.
        return np.clip(self._look_up(TRANSMITTANCE, wavenumber_cm1, paths, empty=1.0), 0.0, 1.0)

    def path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) at the upper end of individual legs, W m-2 sr-1 (cm-1)-1.

        Raises
        ------
        ProviderError
            As :meth:`transmittance`, or if a path has several legs.
        """
        for path in paths:
            if len(path.legs) > 1:
                raise ProviderError(
                    f"lowtran7: path radiance of a path with {len(path.legs)} legs; allowed: a single leg"
                )
        return self._look_up(RADIANCE, wavenumber_cm1, paths, empty=0.0)

    def _look_up(self, wanted: int, wavenumber_cm1: Array, paths: Sequence[Path], empty: float) -> Array:
        """Return values (P, V) at the request; one LOWTRAN7 run computes all paths that are not cached."""
        first, last = _nodes(wavenumber_cm1)
        keys = [(wanted, self._legs(path)) for path in paths]
        new = [
            key
            for key in dict.fromkeys(keys)
            if key[1] and not (key in self._known and self._known[key].covers(first, last))
        ]
        if new:
            self._compute(new, first, last)
        result = np.full((len(paths), wavenumber_cm1.size), empty)
        nodes = STEP_CM1 * np.arange(first, last + 1)
        for row, key in enumerate(keys):
            if key[1]:
                known = self._known[key]
                values = known.values[first - known.first : last - known.first + 1]
                result[row] = np.interp(wavenumber_cm1, nodes, values)
        return result

    def _compute(self, keys: Sequence[tuple[int, tuple[Leg, ...]]], first: int, last: int) -> None:
        for key in keys:  # one run over all that is and will be known, so that a spectrum has no gap
            if key in self._known:
                known = self._known[key]
                first = min(first, known.first)
                last = max(last, known.first + known.values.size - 1)
        jobs = [Job(wanted, tuple(self._deck(wanted, leg) for leg in legs)) for wanted, legs in keys]
        values = spectra(self._program, jobs, STEP_CM1 * first, STEP_CM1 * last)
        if any(wanted == RADIANCE for wanted, _ in keys):
            # W cm-2 -> W m-2 gives 1e4; d(wavelength)/d(wavenumber) = 1e4 / nu^2 um per cm-1 the rest.
            values = values * 1e8 / (STEP_CM1 * np.arange(first, last + 1)) ** 2
        for key, row in zip(keys, values, strict=True):
            self._known[key] = _Spectrum(first, row)

    def _legs(self, path: Path) -> tuple[Leg, ...]:
        """Return the legs that cross air in sorted order, so that sums do not depend on the order in the path."""
        crossing = [leg for leg in path.legs if leg.lower_m < min(leg.upper_m, self._top_m)]
        return tuple(sorted(crossing, key=lambda leg: (leg.lower_m, leg.upper_m, leg.zenith_deg)))

    def _deck(self, wanted: int, leg: Leg) -> str:
        angle = local_zenith_deg(leg.zenith_deg, leg.lower_m)
        lower_km = leg.lower_m / 1000.0
        if leg.upper_m >= self._top_m:
            ray = Ray(TO_SPACE, lower_km, 0.0, angle)
        else:
            ray = Ray(SLANT, lower_km, leg.upper_m / 1000.0, angle)
        return deck(self._air, ray, RADIANCE_RUN if wanted == RADIANCE else TRANSMITTANCE_RUN)


def _nodes(wavenumber_cm1: Array) -> tuple[int, int]:
    """Return the first and last node enclosing the request, in multiples of 5 cm-1; there are at least two nodes."""
    low, high = float(wavenumber_cm1[0]), float(wavenumber_cm1[-1])
    if low < FIRST_CM1 or high > LAST_CM1:
        raise ProviderError(
            f"lowtran7: wavenumbers {low:.6g} to {high:.6g} cm-1; allowed {FIRST_CM1:g} to {LAST_CM1:g} cm-1 "
            f"({1e4 / LAST_CM1:.3g} to {1e4 / FIRST_CM1:.3g} um)"
        )
    first, last = int(np.floor(low / STEP_CM1)), int(np.ceil(high / STEP_CM1))
    return first, max(last, first + 1)


def _notes(air: Air, inputs: AtmosphereInputs, parameters: Lowtran7Parameters) -> tuple[str, ...]:
    """Return the notes for the user."""
    visible = f", visibility {parameters.visibility_km:g} km" if parameters.visibility_km else ""
    notes = [f"LOWTRAN7 revision 4.2, Fortran, {parameters.precision} precision; aerosol {parameters.aerosol}{visible}"]
    if air.levels is None:
        notes.append(f"LOWTRAN7's own model atmosphere {air.model} for profile {inputs.profile.name}")
        return tuple(notes)
    count = air.levels.altitude_km.size
    text = f"profile {inputs.profile.name} on {count} levels"
    if count < inputs.profile.altitude_m.size:
        departure = temperature_departure_K(air.levels, inputs.profile)
        text += f" of its {inputs.profile.altitude_m.size} (temperature within {departure:.2g} K up to 20 km)"
    notes.append(text)
    missing = missing_gases(air.levels)
    if missing:
        notes.append(f"gases from the 1976 US Standard atmosphere, not in the profile: {', '.join(missing)}")
    return tuple(notes)
