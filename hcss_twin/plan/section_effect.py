"""The effect of points of a section that a package owns, and what it makes of a setting."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.core.errors import ProviderError
from hcss_twin.core.plugins import naming_plugin
from hcss_twin.providers import Catalog, ColumnSetting, PointEffect
from hcss_twin.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class SectionEffect:
    """The effect of a section of a scenario.

    Attributes
    ----------
    name : str
        Of the section.
    code : str
        What results depend on beyond the scenario: distribution and version that own the section.
    given : PointEffect
    """

    name: str
    code: str
    given: PointEffect
    _settings: dict[tuple[ColumnSetting, float], ColumnSetting] = field(default_factory=dict, repr=False)

    def apply(self, setting: ColumnSetting, value: float) -> ColumnSetting:
        """Return the setting at a value; one for each, so that its columns are known again."""
        if (setting, value) not in self._settings:
            with self._naming("apply"):
                changed = self.given.apply(setting, value)
            if changed.transmittance is not setting.transmittance or changed.profile is not setting.profile:
                changed = replace(changed, air_memory=None)
            self._settings[setting, value] = changed
        return self._settings[setting, value]

    def values(self, x_m: Array, y_m: Array, time_s: float) -> Array:
        """Return the values at some places.

        Raises
        ------
        ProviderError
            If they are not finite numbers within the range, of the shape of the places.
        """
        given = self.given
        with self._naming("values"):
            values = np.asarray(given.values(x_m, y_m, time_s), dtype=np.float64)
        if values.shape != x_m.shape or not np.all((values >= given.low) & (values <= given.high)):
            raise ProviderError(
                f"section '{self.name}' of {self.code}: values of shape {values.shape} from "
                f"{np.min(values, initial=np.inf):g} to {np.max(values, initial=-np.inf):g}; allowed: shape "
                f"{x_m.shape}, from {given.low:g} to {given.high:g}"
            )
        return values

    def _naming(self, member: str) -> AbstractContextManager[None]:
        return naming_plugin(f"section '{self.name}' of {self.code}: {member}()", type(self.given).__module__)


def section_effects(scenario: Scenario, catalog: Catalog) -> tuple[SectionEffect, ...]:
    """Return the effects of a scenario's sections."""
    if not scenario.sections:
        return ()
    from hcss_twin.core.sections import plugin_sections  # not for scenarios without such sections

    return tuple(
        SectionEffect(name, str(owner.origin), owner.make(owner.spec.effect, scenario, catalog))
        for name, owner in plugin_sections().items()
        if name in scenario.sections and owner.spec.effect is not None
    )
