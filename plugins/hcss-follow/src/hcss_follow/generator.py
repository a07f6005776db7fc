"""The cloud generator `followed`: the sky of measured images, moved on and changed as forecast from them."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from hcss_skies.blending import put_in_layer
from hcss_skies.example import Detail
from hcss_skies.pace import Pace
from hcss_skies.refined import RefinedCells
from hcss_skies.tops import between_cells
from numpy.typing import NDArray

from hcss_follow.analysis import doubts
from hcss_follow.coefficients import read_coefficients
from hcss_follow.hanging import HangingClouds, hanging_clouds
from hcss_follow.parameters import FollowedParameters
from hcss_follow.sky import FollowedSky
from hcss_follow.state import Field, State, read_state
from hcss_twin.providers import (
    Array,
    BrightnessInversion,
    Catalog,
    CloudDeclaration,
    CloudInputs,
    CloudLayer,
    ProviderError,
)

_DETAIL = Detail(0.31, 2.3)
"""Detail of images with too little cloud to tell, from SEVIRI and Landsat images."""

_HEIGHTS_M = 3000.0, 6000.0, 9000.0, 12_000.0
"""Limits of the tops of a scene, of which the lowest that holds its clouds counts; above the last there is none."""

_COLDER_K, _HIGHER_M = 4.0, 500.0
"""By how much the clouds of the hours to come may be colder and higher than those of the image."""

_TILE = 512


class FollowedClouds:
    """Clouds that look like the latest image, at lead 0 equal to it in the scene's own radiance.

    Each pixel of the image has the cloud that has its brightness temperature in the scene, with a top that is as much
    above that of an opaque cloud as two channels told. Smaller pixels are means over cells that are halved, as those of
    the generator `example`. What is warmer than the clear sky of the scene is clear.

    Parameters
    ----------
    inputs : CloudInputs
        Layer, image plane, motion, seed, inversion. Wind adds to the measured motion; a followed sky has its own.
    parameters : FollowedParameters

    Raises
    ------
    CatalogError
        If there is no such state, or its file is damaged.
    ProviderError
        Outside a scene, where no radiance tells the thickness.
    """

    honours: tuple[str, ...] = ()
    clear_sky_varies = True
    skipped: tuple[tuple[str, str], ...] = (
        ("several layers of cloud in one pixel of the image", "each pixel has one cloud with one top"),
    )

    def __init__(self, inputs: CloudInputs, parameters: FollowedParameters) -> None:
        self._inputs, self._parameters = inputs, parameters
        if inputs.inversion is None:
            raise ProviderError("followed: brightness temperature is that of a scene; allowed: in a scenario")
        # newest first: when the state came into force, and over how long
        self._skies = [
            (self._sky_of(inputs.catalog.parsed(inputs.catalog.file(parameters.state), read_state)), (-math.inf, 0.0))
        ]
        state = self._skies[0][0].state
        self._start = state.time
        # inversions are hashed by identity
        self._hanging = _hanging(inputs.inversion, inputs.layer, inputs.catalog, parameters.limits_um, state)  # type: ignore[arg-type]
        self._pace = replace(Pace.of(inputs.motion), rate=1.0)
        detail = self._skies[0][0].example.detail or _DETAIL
        if parameters.detail is not None:
            detail = Detail(parameters.detail, detail.exponent)
        self._cells = RefinedCells(inputs.grid, state.pixel_size_m, self._pace, inputs.seed, detail)
        self.cloud_top_range_m = float(self._hanging.altitude_m[0]), float(self._hanging.altitude_m[-1])
        self._last: tuple[tuple[float, ...], Field] | None = None
        self.image_coverage = float(np.mean(state.kelvin < self._hanging.clear_K))
        self.declares = CloudDeclaration(depends_on=frozenset({"time"}), evolves=True, notes=self._notes(state, detail))

    def _notes(self, state: State, detail: Detail) -> tuple[str, ...]:
        of = read_coefficients()
        last = of.leads_s[-1] / 60.0
        notes = [
            f"State {state.number} of {state.time.isoformat()}: {state.source} ({state.rights or 'no terms stated'}).",
            f"Coefficients of the forecast are those of {of.data}, to {last:.0f} min; other weather has others.",
            "mean forecast: smoother the later it is" if self._parameters.member is None
            else f"member {self._parameters.member} of the ensemble",
            "Beyond the image the sky has the image's statistics, not its clouds.",
            "The texture of clear sky is that of the image, as thin cloud, which counts in masks.",
            *doubts(state),
        ]  # fmt: skip
        if not state.two_channels:
            notes.append("One channel: all clouds count as opaque where they are coldest nearby.")
        if self._cells.halvings:
            notes.append(
                f"Detail below {state.pixel_size_m:g} m: strength {detail.strength:.3g}, exponent "
                f"{detail.exponent:.3g}. Edges and fibres inside pixels of the image are made, not measured."
            )
        if any(self._inputs.motion.cloud_velocity_m_s):
            notes.append("The scenario's wind moves the sky in addition to the measured motion; set wind_speed = 0.")
        return tuple(notes)

    def assimilate(self, state: State, time_s: float, over_s: float = 10.0) -> FollowedClouds:
        """Return the generator that goes over to the next state from a time of the scene on, without a jump.

        Parameters
        ----------
        state : State
            Of the same place and pixel size.
        time_s : float
            When the transition begins, s after the start of the scene.
        over_s : float
            How long it takes.

        Raises
        ------
        ProviderError
            If size, pixel size or time do not fit.
        """
        of = self._skies[0][0].state
        if state.shape != of.shape or state.pixel_size_m != of.pixel_size_m or not state.time >= of.time:
            raise ProviderError(
                f"state: {state.shape} pixels of {state.pixel_size_m:g} m at {state.time.isoformat()}; allowed: "
                f"{of.shape} pixels of {of.pixel_size_m:g} m, no earlier than {of.time.isoformat()}"
            )
        if not over_s > 0.0 or not math.isfinite(time_s):
            raise ProviderError(f"time_s {time_s:g}, over_s {over_s:g}; allowed: finite, above 0")
        follower = object.__new__(FollowedClouds)
        vars(follower).update(vars(self), _last=None)
        in_force = [n for n, (_, (from_s, over)) in enumerate(self._skies) if from_s + over <= time_s]
        follower._skies = [
            (self._sky_of(state), (time_s, over_s)),
            *self._skies[: in_force[0] + 1 if in_force else None],
        ]
        return follower

    @property
    def state(self) -> State:
        """The newest state."""
        return self._skies[0][0].state

    def thickness_m(self, time_s: float, rows: slice, columns: slice) -> Field:
        """Return the thickness (y, x) of a window; 0 is clear sky."""
        thickness: Field = self._window(time_s, rows, columns)[0]
        return thickness

    def thickness_around_m(self, time_s: float, rows: slice, columns: slice, summary: None = None) -> Field:
        """Return the thickness (y, x) of a window that may reach outside the image."""
        return self.thickness_m(time_s, rows, columns)

    def cloud_top_m(self, time_s: float, rows: slice, columns: slice) -> Field:
        """Return the altitude of the cloud top (y, x) of any window."""
        top: Field = self._window(time_s, rows, columns)[1]
        return top

    def _sky_of(self, state: State) -> FollowedSky:
        return FollowedSky(state, self._inputs.seed, self._parameters.member)

    def _window(self, time_s: float, rows: slice, columns: slice) -> Field:
        """Return thickness and top (2, y, x) of a window; the last one is kept, as the engine asks for both."""
        if not math.isfinite(time_s):
            raise ValueError(f"time_s: {time_s} given, allowed: any finite time")
        key = time_s, rows.start, rows.stop, columns.start, columns.stop
        last = self._last
        if last is None or last[0] != key:
            out = np.empty((2, max(0, rows.stop - rows.start), max(0, columns.stop - columns.start)), np.float32)
            for i in range(0, out.shape[1], _TILE):
                for j in range(0, out.shape[2], _TILE):
                    self._write(out[:, i : i + _TILE, j : j + _TILE], time_s, rows.start + i, columns.start + j)
            last = self._last = key, out
        return last[1].copy()

    def _write(self, out: Field, time_s: float, row: int, column: int) -> None:
        """Write a part of a frame that begins at ``row`` and ``column``."""
        layer, cells = self._inputs.layer, self._cells
        edges = cells.edges(out.shape[1:], time_s, row, column)
        if not cells.halvings:
            pairs = self._coarse(time_s, edges)
            out[0], out[1] = pairs[..., 0], pairs[..., 1]
        else:
            low, high = cells.regions(edges)[0]
            y, x = (np.arange(*ends, dtype=np.float64) + 0.5 for ends in zip(low, high, strict=True))
            pairs = self._clouds(time_s, y, x)
            most = float(np.float32(layer.thickness_max_m))
            out[0] = cells.means(
                np.ascontiguousarray(pairs[..., 0]), list(low), edges, time_s, most, self._hanging.visible_m
            )
            y, x = (0.5 * (edge[1:] + edge[:-1]) - 0.5 for edge in edges)
            out[1] = between_cells(pairs[..., 1].astype(np.float64), y, x, low)
            np.minimum(out[0], out[1], out=out[0])
        thickness = np.ascontiguousarray(out[0])
        put_in_layer(thickness, np.float32(layer.thickness_min_m), np.float32(layer.thickness_max_m))
        out[0] = thickness

    def _coarse(self, time_s: float, edges: list[Array]) -> Field:
        """Return thickness and top (y, x, 2) of pixels no smaller than those of the image: means of what they hold."""
        parts = max(1, round(self._cells.pixel))
        y, x = ((edge[:-1, None] + self._cells.pixel * (np.arange(parts) + 0.5) / parts).ravel() for edge in edges)
        fine = self._clouds(time_s, y, x)
        shape = edges[0].size - 1, parts, edges[1].size - 1, parts, 2
        mean: NDArray[np.float32] = fine.reshape(shape).mean(axis=(1, 3))
        return mean

    def _clouds(self, time_s: float, y: Array, x: Array) -> Field:
        """Return thickness and top (y, x, 2) at positions in pixels of the image from its middle."""
        pairs = self._seen(time_s, y, x)
        self._hanging.look_up(pairs, self._inputs.layer)
        return pairs

    def _seen(self, time_s: float, y: Array, x: Array) -> Field:
        """Return brightness temperature and excess (y, x, 2); the states overlap where one takes over."""
        total: Field | None = None
        for sky, (from_s, over_s) in reversed(self._skies):
            share = (
                1.0
                if from_s == -math.inf or sky is self._skies[-1][0]
                else float(np.clip((time_s - from_s) / over_s, 0.0, 1.0))
            )
            if share == 0.0:
                continue
            lead_s = self._parameters.lead + time_s - (sky.state.time - self._start).total_seconds()
            seen = sky.at(lead_s, y, x)
            part = np.float32(share * share * (3.0 - 2.0 * share))
            total = seen if total is None or share == 1.0 else total + part * (seen - total)
        assert total is not None
        return total


@lru_cache(maxsize=2)
def _hanging(
    inversion: BrightnessInversion, layer: CloudLayer, catalog: Catalog, limits_um: tuple[float, float], state: State
) -> HangingClouds:
    """Return the clouds of a scene up to the tops of a state and those to come; plans make a generator repeatedly."""
    whole = hanging_clouds(inversion.in_band(limits_um), layer, catalog)
    return whole.up_to(_highest_m(whole, state))


def _highest_m(clouds: HangingClouds, state: State) -> float:
    """Return the limit of tops that holds those of a state."""
    tops_m = clouds.tops_m(state.kelvin.astype(np.float64) - _COLDER_K) + state.excess_m
    highest = float(tops_m.max()) + _HIGHER_M
    return next((limit for limit in _HEIGHTS_M if limit >= highest), math.inf)
