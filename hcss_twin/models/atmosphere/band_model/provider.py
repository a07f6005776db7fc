"""Transmittance provider ``band-model``: LOWTRAN7's band model for any profile, with newer or its own coefficients."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import cached_method
from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import ProviderError
from hcss_twin.models.atmosphere.band_model.absorber_density import level_state, surface_humidity_percent
from hcss_twin.models.atmosphere.band_model.absorption import (
    TRACE_GASES,
    Absorption,
    BandModelCoefficients,
    read_coefficients,
)
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.band_model.single_scattering import Illumination, ScatteredSunlight
from hcss_twin.models.atmosphere.gases import with_factors
from hcss_twin.models.atmosphere.native_grid import NativeWindow, native_window
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import COEFFICIENTS, DEFAULT_VISIBILITY_KM, NAVY_MARITIME, BandModelParameters
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.planck import planck
from hcss_twin.providers import AtmosphereDeclaration, AtmosphereInputs, ModelError
from hcss_twin.providers.declarations import Note

if TYPE_CHECKING:
    from hcss_twin.models.atmosphere.band_model.navy_maritime import NavyTables

Nodes = NDArray[np.intp]

_MAX_ZENITH_DEG = 88.0
_RAYS_AT_ONCE = 2
"""Number of rays whose transmittances at every level are held in memory together."""

_OWN_ERRORS = {
    "lowtran7": "band model: transmittance within 2e-4 and path radiance within 0.1 % of LOWTRAN7, to 85 deg",
    "rrtmgp": "band model: transmittances of whole RRTMGP bands within about 0.01 of RRTMGP; structure inside them is "
    "LOWTRAN7's: channels narrower than about 60 cm-1 near 650-760 and 2200-2390 cm-1 by 1 to 4 K",
}
"""By the name of the coefficients."""

_NARROW = Note(
    "coefficients 'rrtmgp' are fitted to whole RRTMGP bands: channels narrower than about 60 cm-1 near 650-760 and "
    "2200-2390 cm-1, whose structure is LOWTRAN7's, may be wrong by 1 to 4 K",
    narrow_cm1=((650.0, 760.0, 60.0), (2200.0, 2390.0, 60.0)),
)


class BandModelTransmittance:
    """Transmittance and thermal emission of the air by LOWTRAN7's band model.

    Parameters
    ----------
    inputs : AtmosphereInputs
        The profile needs water vapour. Missing gases, and always NO, SO2, NO2, NH3 and HNO3, come from the 1976 US
        Standard, as in LOWTRAN7.
    parameters : BandModelParameters

    Raises
    ------
    CatalogError
        If the coefficients cannot be read.
    ProviderError
        If the profile has no water vapour, or the wind-dependent aerosol has no wind or one outside its range.

    Notes
    -----
    Absorber amounts of all legs of a path are added before the band functions are applied. Pressure, temperature and
    gases are used at the profile's own levels; only the wavenumber is interpolated.

    In path radiance, seen from above, aerosol emits all that it takes out of the path: what it scatters it replaces by
    light from below, of nearly its temperature. The sky contains only what aerosol absorbs; the radiance model adds
    what aerosol scatters into it. With LOWTRAN7's own coefficients, as there, all extinction emits in the sky too.
    """

    def __init__(self, inputs: AtmosphereInputs, parameters: BandModelParameters) -> None:
        catalog = inputs.catalog
        coefficients = catalog.shelf.parsed(catalog.find(parameters.file, "atmospheres", ".nc"), read_coefficients)
        sea_air, self._of_wind = "", parameters.aerosol == NAVY_MARITIME
        if parameters.aerosol != "none":
            self.vapour_kinks = partial(_vapour_kinks, inputs, coefficients, parameters)
        if self._of_wind:
            coefficients, visibility_km, sea_air = _of_the_wind(inputs, coefficients, parameters)
            parameters = parameters.model_copy(update={"visibility_km": visibility_km})
        state = level_state(inputs.profile, coefficients, parameters)
        self._air = LayeredAir(state, parameters.earth_radius_m)
        self._absorption = Absorption(coefficients, parameters.aerosol)
        self._scattering = ScatteredSunlight(self._air, self._absorption, coefficients, parameters.aerosol)
        self._wavenumber = coefficients.wavenumber_cm1
        whole = np.unique(self._air.between(0.0, SPACE).temperature_K)
        self._planck = dict(zip(whole.tolist(), planck(self._wavenumber, whole[:, None]), strict=True))
        missing = set(coefficients.channel_gas) - set(TRACE_GASES) - set(inputs.profile.mixing_ratio)
        notes = [f"band model: {coefficients.source}, aerosol {parameters.aerosol}"]
        if parameters.aerosol != "none":
            visibility_km = parameters.visibility_km or DEFAULT_VISIBILITY_KM
            notes[0] += f" ({sea_air}visibility {visibility_km:.4g} km, {parameters.season})"
        if missing:
            named = ", ".join(sorted(missing))
            notes.append(f"band model: {named} of the 1976 US Standard, as the profile does not give them")
        self._named = next((name for name, file in COEFFICIENTS.items() if file == parameters.file), None)
        if self._named == "rrtmgp":
            notes.append(_NARROW)
        if parameters.aerosol != "none" and self._named != "lowtran7":
            self.scattering_of_amounts = self._scattering_of_amounts
        self._window = cached_method(self._make_window, 8)
        self.declares = AtmosphereDeclaration(
            valid={
                "wavenumber_cm1": (float(self._wavenumber[0]), float(self._wavenumber[-1])),
                "view_zenith": (0.0, _MAX_ZENITH_DEG),
            },
            native_grid_cm1=self._wavenumber,
            resolution_cm1=coefficients.resolution_cm1,
            notes=tuple(notes),
            own_errors=() if self._named is None else (_OWN_ERRORS[self._named],),
        )

    def model_errors(self) -> tuple[ModelError, ...]:
        """Return how far the provider is from the best references known; of gas nothing for a file of the user."""
        gas = () if self._named is None else from_table(__file__, f"band-model {self._named}")()
        aerosol = "band-model navy-maritime" if self._of_wind else "band-model"
        return (*gas, *from_table(__file__, aerosol)())

    def transmittance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return transmittance (P, V) of composite paths.

        Raises
        ------
        ProviderError
            If a wavenumber lies outside the declared range. Transmittance allows zenith angles up to the horizon, so
            that the sun can set; emission and scattering end at 88 degrees.
        """
        return self.transmittance_of_amounts(wavenumber_cm1, self.absorber_amounts(paths))

    def absorber_amounts(self, paths: Sequence[Path]) -> Array:
        """Return absorber amounts (P, K) along composite paths; amounts of legs add."""
        return self._air.amounts(paths)

    def transmittance_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        """Return the transmittance (P, V) of absorber amounts (P, K).

        Raises
        ------
        ProviderError
            If a wavenumber lies outside the declared range.
        """
        window = self._window(wavenumber_cm1.tobytes())
        humidity = self._absorption.humidity_percent(amounts)
        native = self._absorption.transmittance(amounts, humidity, window.nodes)
        return window.interpolate(native)

    def _scattering_of_amounts(self, wavenumber_cm1: Array, amounts: Array) -> Array:
        window = self._window(wavenumber_cm1.tobytes())
        found = self._absorption.scattering(amounts, self._absorption.humidity_percent(amounts), window.nodes)
        return np.stack([window.interpolate(each) for each in found])

    def path_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) of single legs as seen from their upper end, W m-2 sr-1 (cm-1)-1.

        Notes
        -----
        Each layer is a black body at its density-weighted mean temperature T_n, so that with the transmittance t_n from
        the upper end to the bottom of layer n the radiance is sum_n B(T_n) (t_n+1 - t_n); an isothermal atmosphere
        gives (1 - t) B.
        """
        return self._emission(wavenumber_cm1, paths, from_above=True)

    def sky_radiance(self, wavenumber_cm1: Array, paths: Sequence[Path]) -> Array:
        """Return thermal emission (P, V) of single legs as seen from their lower end, W m-2 sr-1 (cm-1)-1.

        Without what aerosol scatters into the leg.
        """
        return self._emission(wavenumber_cm1, paths, from_above=False)

    def solar_path_radiance(
        self,
        wavenumber_cm1: Array,
        paths: Sequence[Path],
        sun_zenith_deg: float,
        relative_azimuth_deg: float,
        asymmetry: float | None = None,
    ) -> Array:
        """Return singly scattered sunlight of single legs, seen from the upper end, per unit solar irradiance.

        Parameters
        ----------
        wavenumber_cm1 : ndarray (V,)
        paths : sequence of Path (P,)
        sun_zenith_deg, relative_azimuth_deg : float
            Of the sun at the surface point; azimuth 0 means that sensor and sun are on the same side.
        asymmetry : float, optional
            Of a Henyey-Greenstein phase function for all aerosol, instead of LOWTRAN7's tabulated asymmetry.

        Returns
        -------
        ndarray (P, V)
            sr-1; multiply by the extraterrestrial irradiance (per wavenumber) to get the radiance.

        Raises
        ------
        ProviderError
            If the solar zenith angle exceeds 88 degrees anywhere on a path.
        """
        window = self._window(wavenumber_cm1.tobytes())
        nodes = window.nodes
        sun = Illumination(math.radians(sun_zenith_deg), math.radians(relative_azimuth_deg))
        native = np.zeros((len(paths), nodes.size))
        for row, path in enumerate(paths):
            if len(path.legs) > 1:
                raise ProviderError("band model: scattered sunlight is known for single legs only")
            for leg in path.legs:
                _check(leg)
                native[row] = self._scattering.radiance(leg, sun, nodes, asymmetry)
        return window.interpolate(native)

    def _emission(self, wavenumber_cm1: Array, paths: Sequence[Path], *, from_above: bool) -> Array:
        window = self._window(wavenumber_cm1.tobytes())
        nodes = window.nodes
        native = np.zeros((len(paths), nodes.size))
        rays: dict[tuple[float, float], list[tuple[int, float]]] = {}
        for row, path in enumerate(paths):
            if len(path.legs) > 1:
                raise ProviderError("band model: emission is known for single legs only")
            for leg in path.legs:
                _check(leg)
                rays.setdefault((leg.lower_m, leg.upper_m), []).append((row, leg.zenith_deg))
        for (lower, upper), members in rays.items():
            layers = self._air.between(lower, upper)
            if not layers.temperature_K.size:
                continue
            # Starting at the observer's end.
            order = slice(None, None, -1 if from_above else 1)
            black_bodies = self._black_bodies(layers.temperature_K[order], nodes)
            for start in range(0, len(members), _RAYS_AT_ONCE):
                some = members[start : start + _RAYS_AT_ONCE]
                slant = self._air.slant(layers, lower, np.array([angle for _, angle in some]))
                by_layer = np.add.reduceat(slant[:, :, None] * layers.amount, layers.first_cell, axis=1)
                seen = self._cumulative_transmittance(by_layer[:, order], nodes)
                emission, before = np.zeros((2, len(some), nodes.size))
                before += 1.0
                source: Iterable[Array] = black_bodies
                if not from_above and hasattr(self, "scattering_of_amounts"):
                    source = self._absorbed(by_layer, seen, nodes) * np.stack(black_bodies)[:, None]
                for black, beyond in zip(source, seen, strict=True):
                    before -= beyond
                    # Without absorption, rounding could give negative values.
                    np.maximum(before, 0.0, out=before)
                    before *= black
                    emission += before
                    before[...] = beyond
                native[[row for row, _ in some]] = emission
        return window.interpolate(native)

    def _absorbed(self, amounts: Array, seen: Array, nodes: Nodes) -> Array:
        """Return the share (L, P, N) of absorption in what layers with amounts (P, L, K) take out of rays."""
        from hcss_twin.physics.thermal_scattering import scattered_share  # not for masks alone

        flat = amounts.reshape(-1, amounts.shape[2])
        depth, _ = self._absorption.scattering(flat, self._absorption.humidity_percent(flat), nodes)
        through = np.concatenate((np.ones((1, *seen.shape[1:])), seen)).swapaxes(0, 1)
        share = scattered_share(through, depth.reshape(*amounts.shape[:2], -1))
        result: Array = 1.0 - share.swapaxes(0, 1)
        return result

    def _make_window(self, wavenumbers: bytes) -> NativeWindow:
        return native_window(self._wavenumber, np.frombuffer(wavenumbers, dtype=np.float64), "band model")

    def _black_bodies(self, temperature_K: Array, nodes: Nodes) -> list[Array]:
        """Return the Planck radiances of layers, from a table for the profile's own layers."""
        wavenumber = self._wavenumber[nodes]
        return [
            known[nodes] if (known := self._planck.get(float(kelvin))) is not None else planck(wavenumber, kelvin)
            for kelvin in temperature_K
        ]

    def _cumulative_transmittance(self, amount: Array, nodes: Nodes) -> Array:
        """Return the transmittance (L, P, N) through the first 1, 2, ... L layers, from amounts (P, L, K)."""
        cumulative = np.cumsum(amount, axis=1).swapaxes(0, 1)
        count, rays, columns = cumulative.shape
        # One mean humidity for the whole ray, as in LOWTRAN7; cumulative means could make layer emission negative.
        humidity = np.tile(self._absorption.humidity_percent(cumulative[-1]), count)
        amounts = cumulative.reshape(count * rays, columns)
        return self._absorption.transmittance(amounts, humidity, nodes).reshape(count, rays, -1)


def _navy_tables(catalog: Catalog) -> NavyTables:
    from hcss_twin.models.atmosphere.band_model import navy_maritime  # only for scenes that use it

    return navy_maritime.read_navy_maritime(catalog.find(navy_maritime.FILE, "atmospheres", ".nc"))


def _of_the_wind(
    inputs: AtmosphereInputs, coefficients: BandModelCoefficients, parameters: BandModelParameters
) -> tuple[BandModelCoefficients, float, str]:
    """Return the coefficients with the Navy maritime aerosol, its visibility in km, and its inputs for the note."""
    from hcss_twin.models.atmosphere.band_model import navy_maritime  # only for scenes that use it

    wind = inputs.wind_speed_m_s
    if wind is None:
        raise ProviderError(f"band model: aerosol '{NAVY_MARITIME}' needs a wind speed; allowed without: 'maritime'")
    profile, catalog, day = inputs.profile, inputs.catalog, parameters.wind_24h_m_s
    humidity = surface_humidity_percent(profile, coefficients)
    character = parameters.air_mass_character or navy_maritime.DEFAULT_CHARACTER
    air = navy_maritime.SeaAir(wind, wind if day is None else day, humidity, character)
    tables = _navy_tables(catalog)
    aerosol, visibility_km = navy_maritime.with_navy_maritime(
        coefficients.aerosol, tables, air, parameters.visibility_km
    )
    low, high = tables.humidity_percent[[0, -1]]
    beyond = "" if low <= humidity <= high else f", for which the model takes {min(max(humidity, low), high):g} %"
    state = (
        f"wind {air.wind_m_s:.3g} m/s, mean of 24 h {air.wind_24h_m_s:.3g} m/s, character {character}, humidity "
        f"{humidity:.0f} %{beyond}; "
    )
    return replace(coefficients, aerosol=aerosol), visibility_km, state


def _vapour_kinks(
    inputs: AtmosphereInputs,
    coefficients: BandModelCoefficients,
    parameters: BandModelParameters,
    low: float,
    high: float,
) -> tuple[float, ...]:
    """Return the factors on the water vapour, within a range, at which the tables of haze have a kink; ascending.

    They have few humidities: haze is interpolated between those of the air at the sea, if it depends on wind, or else
    of the whole path.
    """
    from scipy.optimize import brentq  # few scenes need it

    def humidity_percent(factor: float) -> float:
        profile = with_factors(inputs.profile, {"h2o": factor})
        if parameters.aerosol == NAVY_MARITIME:
            return surface_humidity_percent(profile, coefficients)
        air = LayeredAir(level_state(profile, coefficients, parameters), parameters.earth_radius_m)
        return float(absorption.humidity_percent(air.amounts([to_space(0.0, 0.0)]))[0])

    absorption, nodes = Absorption(coefficients, parameters.aerosol), 100.0 - np.exp(coefficients.aerosol.ln_dryness)
    if parameters.aerosol == NAVY_MARITIME:
        nodes = _navy_tables(inputs.catalog).humidity_percent
    driest, moistest = humidity_percent(low), humidity_percent(high)
    return tuple(
        float(brentq(lambda factor, node=node: humidity_percent(factor) - node, low, high, xtol=1e-4))
        for node in nodes.tolist()
        if driest < node < moistest
    )


def _check(leg: Leg) -> None:
    if leg.zenith_deg > _MAX_ZENITH_DEG:
        raise ProviderError(
            f"band model: zenith angle {leg.zenith_deg:g} deg at the surface; allowed 0 to {_MAX_ZENITH_DEG:g} deg"
        )
