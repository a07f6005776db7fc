"""Frames of a scenario in memory, one after another, for programs that do not want files."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.arguments import checked
from hcss_twin.core.environment import announce_compilation
from hcss_twin.core.errors import Problem, ScenarioError
from hcss_twin.cube.variables import TOTAL
from hcss_twin.engine.certificate.certificate import Certificate
from hcss_twin.engine.certificate.certificate_pixels import PixelSample
from hcss_twin.engine.certificate.certify import certify, with_verdict
from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.scenario.scenario import Scenario


@dataclass(frozen=True, eq=False)
class TwinFrame:
    """One frame, before any sensor.

    Attributes
    ----------
    number : int
        Of the scenario's frames, from 0.
    time_s : float
        After the scenario's start.
    variables : mapping of str to ndarray
        All variables that the scenario requests, with the names, units, axes and bits of the cube, without ``time``.
    """

    number: int
    time_s: float
    variables: Mapping[str, NDArray[Any]]

    @property
    def radiance(self) -> NDArray[np.float32]:
        """Band radiance (band, row, column), W m-2 sr-1; the first row is the southern one."""
        return self.variables[TOTAL]


class Twin:
    """A planned scenario whose frames are computed when they are asked for.

    Parameters
    ----------
    scenario : Scenario, str, Path or dict
        What to simulate, as for :func:`hcss_twin.simulate`. Its sensor, if any, is not applied: frames are those of
        the clean cube.

    Attributes
    ----------
    plan : Plan
        The decisions: accuracy, omitted physics, variables.

    Raises
    ------
    ScenarioError, ProviderError
        As :func:`hcss_twin.make_plan`.
    """

    @checked
    def __init__(self, scenario: Scenario | str | Path | dict[str, Any]) -> None:
        self.plan = make_plan(scenario)

    @checked
    def frames(self, numbers: Sequence[int] | None = None) -> Iterator[TwinFrame]:
        """Yield frames with the bits of the cube; memory use does not depend on their number.

        Parameters
        ----------
        numbers : sequence of int, optional
            Which frames, from 0; by default all in the order of time.

        Raises
        ------
        ScenarioError
            If there is no frame with a number.
        """
        times_s = self.plan.frame_times_s
        numbers = range(times_s.size) if numbers is None else numbers
        beyond = [number for number in numbers if not 0 <= number < times_s.size]
        if beyond:
            raise ScenarioError([Problem("frames", f"number {beyond[0]} asked for; allowed: 0 to {times_s.size - 1}")])
        return self._frames(numbers)

    def certificate(self) -> Certificate | None:
        """Return the certificate of the cube; None if the scenario draws no pixels for it or has no radiance.

        It computes the frames that it checks.
        """
        if self._tables is None or not self.plan.scenario.output.certificate:
            return None
        sample = PixelSample(self.plan)
        for _ in stream(self.plan, self._tables, sample, sorted(sample.counts)):
            pass
        return with_verdict(self.plan, certify(self.plan, self._tables, sample.frames))

    def _frames(self, numbers: Sequence[int]) -> Iterator[TwinFrame]:
        for number, variables in zip(numbers, stream(self.plan, self._tables, frames=numbers), strict=True):
            yield TwinFrame(number, float(self.plan.frame_times_s[number]), variables)

    @cached_property
    def _tables(self) -> RadianceTables | None:
        with announce_compilation(logging.getLogger(__name__).warning):
            return tables_of(self.plan) if self.plan.needs_radiance else None
