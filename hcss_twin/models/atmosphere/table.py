"""Transmittance provider ``table``: interpolation of tabulated transmittance and path radiance.

A composite path is looked up by its *total* air mass above its lowest point: absorber amounts add along the legs, so
that sun -> sea -> sensor is one long path, not the product of two transmittances (which would be too small where lines
are saturated).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.native_grid import native_nodes, native_window
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.same_profile import difference, unstated
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.models.parameters import TableParameters
from hcss_twin.physics.monotone_cubic import WINDOW, pchip_in_window, window_start
from hcss_twin.physics.paths import SPACE, Path
from hcss_twin.physics.profile import Profile
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs
from hcss_twin.providers.declarations import Note

# Limits of T in ln(-ln T), which is infinite at 0 and 1.
_MIN_TRANSMITTANCE = 1e-30
_MAX_TRANSMITTANCE = 1.0 - 1e-7

PROVIDER = "atmosphere table"
"""Name of this provider in messages."""

CATALOG_PROFILES = {"us-standard-1976-lowtran7": "us-standard-1976"}
"""Profiles of built-in tables by catalog name; other tables contain only their own levels."""


class TableTransmittance:
    """Interpolates an atmosphere table.

    Parameters
    ----------
    inputs : AtmosphereInputs
        The profile gives cloud temperatures; it must be that of the table
        (:func:`hcss_twin.models.atmosphere.same_profile.difference`).
    parameters : TableParameters
        Which table.

    Raises
    ------
    CatalogError
        If the table cannot be read.
    ProviderError
        If the profile of the scenario is not that of the table.

    Notes
    -----
    ln(-ln T) and path radiance / (1 - T) are interpolated by monotone cubics: first in ln(pressure) of the target at
    the table's zenith angles, then in ln(air mass). Between the nodes of the built-in table this is within 4e-4 of
    LOWTRAN7 at every wavenumber and 2e-4 in band means; path radiance within 0.25 %. A path with two legs of different
    zenith angles is treated as the slant path of equal air mass.
    """

    def __init__(self, inputs: AtmosphereInputs, parameters: TableParameters) -> None:
        table = AtmosphereTable.read(inputs.catalog.find(parameters.file, "atmospheres", ".nc"))
        self._profile = table.profile
        table_profile = _profile_of(table, parameters.file, inputs.catalog)
        other = difference(inputs.profile, table_profile)
        if other:
            raise ProviderError(
                f"the atmosphere table '{parameters.file}' was computed for other air than profile "
                f"'{inputs.profile.name}': {other}"
            )
        self._wavenumber = table.wavenumber_cm1
        self._zenith = table.zenith_deg
        depth = -np.log(np.clip(table.transmittance, _MIN_TRANSMITTANCE, _MAX_TRANSMITTANCE))
        fields = np.stack((np.log(depth), table.path_radiance / -np.expm1(-depth)), axis=1)
        self._ln_pressure = -np.log(self._profile.pressure_at(table.target_altitude_m))
        self._fields = fields  # (heights, 2, angles, wavenumbers)
        self._fields_at = cached_method(self._choose_fields, 2)
        self._target_range_m = float(table.target_altitude_m[0]), float(table.target_altitude_m[-1])
        self.declares = AtmosphereDeclaration(
            valid={
                "wavenumber_cm1": (float(self._wavenumber[0]), float(self._wavenumber[-1])),
                "view_zenith": (float(self._zenith[0]), float(self._zenith[-1])),
                "target_altitude_m": self._target_range_m,
            },
            native_grid_cm1=self._wavenumber,
            legs="to_space",
            resolution_cm1=table.resolution_cm1,
            notes=(
                f"atmosphere table {parameters.file}: {table.source}",
                Note(
                    "sun-target-sensor transmittance: one slant path of the same total air mass, not a product of legs",
                    sunlight=True,
                ),
                *_unverified(table),
                *_unstated(inputs.profile, table_profile, parameters.file),
            ),
        )

    @staticmethod
    def bound_profile(parameters: TableParameters, catalog: Catalog) -> Profile:
        """Return the profile that the table was computed with; raises CatalogError."""
        table = AtmosphereTable.read(catalog.find(parameters.file, "atmospheres", ".nc"))
        return _profile_of(table, parameters.file, catalog)

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of composite paths whose legs all run from one target to space.

        Raises
        ------
        ProviderError
            If a path has another form or lies outside the table.
        """
        ln_depth, _ = self._look_up(wavenumber_cm1, paths)
        return self._to_requested(wavenumber_cm1, np.exp(-np.exp(ln_depth)))

    def path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) of single legs to space, W m-2 sr-1 (cm-1)-1."""
        if any(len(path.legs) > 1 for path in paths):
            raise ProviderError("atmosphere table: path radiance is known for single legs to space only")
        ln_depth, source = self._look_up(wavenumber_cm1, paths)
        return self._to_requested(wavenumber_cm1, -np.expm1(-np.exp(ln_depth)) * source)

    def _look_up(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Interpolate both fields at the table's own wavenumbers around the request: (2, P, N)."""
        chosen = native_nodes(self._wavenumber, wavenumber_cm1, PROVIDER)
        result = np.zeros((2, len(paths), chosen.size))
        result[0] = -np.inf  # no absorber: transmittance 1
        rows = [row for row, path in enumerate(paths) if path.legs]
        if not rows:
            return result
        targets = np.array([self._target(paths[row]) for row in rows])
        unique, which = np.unique(targets, return_inverse=True)
        nodes = np.log([self._profile.mean_airmass(target, self._zenith) for target in unique])[which]
        airmass = np.log([self._airmass(paths[row], target) for row, target in zip(rows, targets, strict=True)])
        height = -np.log(self._profile.pressure_at(targets))
        # Four nodes of each, or all if the table has fewer.
        heights = np.arange(min(WINDOW, self._ln_pressure.size))
        angles = np.arange(min(WINDOW, self._zenith.size))
        at_height = window_start(self._ln_pressure, height)[:, None] + heights
        at_angle = window_start(nodes, airmass)[:, None] + angles
        # (P, heights, 2, angles, N): only the nodes around each path.
        fields = self._fields_at(chosen.tobytes())
        around = fields[at_height[:, :, None], :, at_angle[:, None, :]].swapaxes(2, 3)
        at_target = pchip_in_window(self._ln_pressure[at_height], around, height)
        local_nodes = np.take_along_axis(nodes, at_angle, axis=1)
        values = pchip_in_window(local_nodes, at_target.swapaxes(1, 2), airmass)
        result[:, rows] = values.swapaxes(0, 1)
        return result

    def _choose_fields(self, nodes: bytes) -> Array:
        return np.ascontiguousarray(self._fields[..., np.frombuffer(nodes, dtype=np.intp)])

    def _target(self, path: Path) -> float:
        target = path.legs[0].lower_m
        if any(leg.lower_m != target or leg.upper_m != SPACE for leg in path.legs):
            raise ProviderError("atmosphere table: every leg must reach from the same target to space")
        low, high = self._target_range_m
        if not low <= target <= high:
            allowed = f"{low:g} to {high:g} m" if high > low else f"{low:g} m alone, the table's only height"
            raise ProviderError(f"atmosphere table: target at {target:g} m; allowed {allowed}")
        return target

    def _airmass(self, path: Path, target: float) -> float:
        """Return the total air mass of a composite path, relative to the vertical path above its target."""
        angles = np.array([leg.zenith_deg for leg in path.legs])
        airmass = float(np.sum(self._profile.mean_airmass(target, angles)))
        ends = self._profile.mean_airmass(target, self._zenith[[0, -1]])
        smallest, largest = float(ends[0]), float(ends[1])
        if not smallest * (1 - 1e-12) <= airmass <= largest * (1 + 1e-12):
            named = " + ".join(f"{angle:.4g}" for angle in angles)
            low, high = self._zenith[0], self._zenith[-1]
            allowed = (
                f"{smallest:.3g} to {largest:.3g} (zenith {low:g} to {high:g} deg)"
                if high > low
                else f"{largest:.3g} alone (zenith {high:g} deg, the table's only angle)"
            )
            raise ProviderError(
                f"atmosphere table: a path with zenith {named} deg has air mass {airmass:.3g}; allowed {allowed}"
            )
        return min(max(airmass, smallest), largest)

    def _to_requested(self, wavenumber_cm1: Array, native: Array) -> Array:
        """Interpolate from the table's wavenumbers to the requested ones (band edges)."""
        return native_window(self._wavenumber, wavenumber_cm1, PROVIDER).interpolate(native)


def _profile_of(table: AtmosphereTable, file: str, catalog: Catalog) -> Profile:
    known = CATALOG_PROFILES.get(file)
    return table.profile if known is None else load_profile(known, catalog)


def _unstated(given: Profile, table_profile: Profile, file: str) -> tuple[str, ...]:
    """Return a note on gases of the profile that cannot be compared, as the table does not state them."""
    gases = ", ".join(gas.upper() for gas in unstated(given, table_profile))
    text = (
        f"the atmosphere table '{file}' does not state its {gases}: the radiance has what it was computed with, "
        f"whatever profile '{given.name}' says"
    )
    return (text,) if gases else ()


def _unverified(table: AtmosphereTable) -> tuple[str, ...]:
    """Return a note on the unknown interpolation error, if the file does not state it."""
    if table.interpolation_error is not None:
        return ()
    heights, angles = table.target_altitude_m.size, table.zenith_deg.size
    between = {1: "that one only", 2: "linear between them", 3: "cubic through them"}
    return (
        f"the interpolation error of this table is unverified: {heights} heights "
        f"({between.get(heights, 'monotone cubic between them')}), {angles} zenith angles "
        f"({between.get(angles, 'monotone cubic between them')})",
    )
