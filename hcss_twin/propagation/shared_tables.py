"""Radiance tables of draws: made once for all that they are the same for."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import partial

from hcss_twin.scene.brightness import BrightnessTemperature
from hcss_twin.scene.compile import compile_tables
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.kept_tables import table_key, tables_of
from hcss_twin.scene.tables.radiance_tables import RadianceTables

_HELD = 4
"""Tables in memory: all that one draw and the last need."""


@dataclass
class TableCount:
    """How often tables were made.

    Attributes
    ----------
    scenes : int
        Scenes that asked for tables.
    sets : int
        Different tables that they needed, if no more than a few different ones come in a row.
    compiled : int
        Those of them that were compiled; the others were kept from earlier runs.
    """

    scenes: int = 0
    sets: int = 0
    compiled: int = 0


class SharedTables:
    """Gives the tables of one plan after the other.

    Attributes
    ----------
    count : TableCount
    """

    def __init__(self) -> None:
        self.count = TableCount()
        self._held: OrderedDict[str, RadianceTables] = OrderedDict()
        self._temperatures: OrderedDict[bytes, BrightnessTemperature] = OrderedDict()

    def of(self, plan: Plan) -> RadianceTables:
        """Return the tables of a plan, the same to the bit as those of a run of its own."""
        self.count.scenes += 1
        key = f"{table_key(plan)} {plan.views} {plan.grid if plan.views is not None else None}"
        if key not in self._held:
            self.count.sets += 1
            compiled: list[Plan] = []  # of several views, where pixels have views of their own
            self._held[key] = tables_of(plan, partial(_noted, compiled))
            self.count.compiled += bool(compiled)
            while len(self._held) > _HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(key)
        return self._held[key]

    def temperature(self, plan: Plan) -> BrightnessTemperature:
        """Return what turns radiance into brightness temperature; its table takes longer than a small frame."""
        grid = plan.spectral_grid
        key = grid.wavenumber_cm1.tobytes() + grid.weights_cm1.tobytes()
        if key not in self._temperatures:
            self._temperatures.clear()
            self._temperatures[key] = BrightnessTemperature(grid, [band.name for band in plan.bands])
        return self._temperatures[key]


def _noted(compiled: list[Plan], plan: Plan) -> RadianceTables:
    compiled.append(plan)
    return compile_tables(plan)
