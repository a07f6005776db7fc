"""Radiance models ``physical`` and ``physical-two-stream``: clouds that scatter many times over a rough, emissive sea.

Columns of one setting are those of :mod:`~hcss_twin.models.radiance.physical.setting_columns`. For each of them,
:class:`~hcss_twin.models.radiance.physical.columns.SceneColumns` stacks air, clouds and sea,
:mod:`~hcss_twin.models.radiance.physical.tracing` follows rays from the sensor into them, and
:mod:`~hcss_twin.models.radiance.physical.closure` sums the reflections that remain.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from os.path import dirname
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.cached_method import weakly
from hcss_twin.core.one_thread import in_one_thread
from hcss_twin.models.model_errors import from_table
from hcss_twin.models.parameters import PhysicalParameters
from hcss_twin.models.radiance.physical.numerics import Numerics, levels
from hcss_twin.models.radiance.physical.terms import SEA_SUN_TERMS, SOLAR_TERMS, TERMS
from hcss_twin.providers import ColumnSetting, ColumnStates, RadianceDeclaration, RadianceInputs, Sun, View

if TYPE_CHECKING:
    from hcss_twin.models.radiance.physical.cloud_slab import LayerOptics
    from hcss_twin.models.radiance.physical.setting_columns import SettingColumns

_SETTINGS = 4
"""Settings whose solutions are kept: there can be hundreds, most are used once, and their arrays can take 100 MB."""

_ANY = View(0.0, 0.0)
"""Stands for any view."""


class Physical:
    """Multiple-scattering model of sea, clouds and air that conserves energy exactly.

    At the sea and at each cloud face, emissivity is 1 minus reflection and transmission. Air attenuates and emits along
    whole composite paths, whose absorber amounts add. An isothermal enclosure therefore emits the Planck radiance in
    every direction, with any providers.

    Parameters
    ----------
    inputs : RadianceInputs
        Any number of cloud layers that do not overlap.
    parameters : PhysicalParameters
        Accuracy, and terms to leave out.

    Raises
    ------
    ProviderError
        If the emissivity and the BRDF of the sea model contradict each other.
    """

    terms: Mapping[str, str] = TERMS
    solar_terms = SOLAR_TERMS
    sea_sun_terms = SEA_SUN_TERMS
    closed_form: ClassVar[bool] = False
    """Whether clouds are solved by the two-stream closed form."""
    model_errors = from_table(dirname(__file__), "physical")

    def __init__(self, inputs: RadianceInputs, parameters: PhysicalParameters) -> None:
        self._inputs = inputs
        self._parameters = parameters
        possible = levels(parameters, inputs.sunlight_steps)
        self._numerics = possible[min(inputs.numerical_level, len(possible) - 1)]
        self._optics: LayerOptics | None = None
        self._of_setting = lru_cache(maxsize=_SETTINGS)(weakly(self._new_columns))
        self.declares = RadianceDeclaration(
            depends_on=frozenset({"view_zenith", "sun_zenith", "relative_azimuth", "thickness"}),
            notes=_notes(parameters, self._numerics, inputs, self.closed_form),
            numerical_levels=len(possible),
        )

    @in_one_thread
    def columns(self, states: ColumnStates, wavenumber_cm1: Array) -> Mapping[str, Array]:
        """Return terms (N, V) of columns. Clouds are solved for all suns of a setting, or for all views, at once."""
        results = states.empty(self.terms, wavenumber_cm1)
        groups = list(states.groups())
        _, views = _together(group.setting for group in groups)
        suns, _ = _together(group.setting for group in groups if np.any(group.thickness_m))
        several = len({group.setting.under(None) for group in groups}) > 1
        for rows, setting, thickness_m in groups:
            beside = suns.get(setting.under(None), [setting.sun]), views[replace(setting, view=_ANY)]
            columns = self._of_setting(setting.under(None))
            for name, values in columns.terms(wavenumber_cm1, thickness_m, setting.sun, *beside, several).items():
                results[name][rows] = values
        return results

    def _new_columns(self, setting: ColumnSetting) -> SettingColumns:
        # The solvers: a scene whose results are kept, or that asks for no radiance, does without them.
        from hcss_twin.models.radiance.physical.cloud_slab import LayerOptics
        from hcss_twin.models.radiance.physical.setting_columns import SettingColumns

        if self._optics is None:
            self._optics = LayerOptics(self._inputs.optics)
        return SettingColumns(setting, self._inputs, self._parameters, self._numerics, self._optics, self.closed_form)


class PhysicalTwoStream(Physical):
    """As :class:`Physical`, but with delta-Eddington two-stream clouds and exact single scattering.

    Energy is still conserved, and an isothermal enclosure is still black. Errors of single layers against discrete
    ordinates are in docs/development/radiance.md: about 0.02 in emissivity and 15 percent in reflected sunlight.
    """

    closed_form = True
    model_errors = from_table(dirname(__file__), "physical-two-stream")


def _together(
    settings: Iterable[ColumnSetting],
) -> tuple[dict[ColumnSetting, list[Sun | None]], dict[ColumnSetting, list[View]]]:
    """Return the suns of settings that are alike but for the sun, and the views of those alike but for the view."""
    suns: dict[ColumnSetting, list[Sun | None]] = {}
    views: dict[ColumnSetting, list[View]] = {}
    for setting in settings:
        suns.setdefault(setting.under(None), []).append(setting.sun)
        views.setdefault(replace(setting, view=_ANY), []).append(setting.view)
    return suns, views


def _notes(
    parameters: PhysicalParameters, numerics: Numerics, inputs: RadianceInputs, closed_form: bool
) -> tuple[str, ...]:
    streams = f"{numerics.streams} streams, {numerics.sun_streams} for sunlight"
    notes = [f"physical radiance: {streams}, gas exact for {parameters.closure_order} changes"]
    if closed_form:
        notes.append("physical radiance: clouds by a two-stream closed form, see docs/development/radiance.md")
    if inputs.setting.transmittance.declares.legs == "to_space":
        notes.append(
            "physical radiance: the atmosphere knows paths to space only; others by a power law fitted to them, "
            "a few percent off where light goes down and up again"
        )
    if parameters.leave_out:
        notes.append(f"terms left out by choice: {', '.join(parameters.leave_out)}")
    return tuple(notes)
