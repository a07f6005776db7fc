"""Frames: thickness from the generators, radiance by look-up, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.bit_rounding import round_bits
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.scene.brightness import BrightnessTemperature
from hcss_twin.scene.certificate.certificate_pixels import PixelSample
from hcss_twin.scene.footprint import Window, length, relative, windows
from hcss_twin.scene.frame_clouds import FrameClouds
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.slant.shadows import InstantShadows, Shadows
from hcss_twin.scene.tables.look_up import LookUp
from hcss_twin.scene.tables.radiance_tables import TOTAL, RadianceTables, TableReader
from hcss_twin.scene.truth import Truth
from hcss_twin.scene.views.viewed_look_up import ViewedLookUp
from hcss_twin.scene.waves.waves import WaveStage

Frame = dict[str, NDArray[Any]]


class Onlooker(Protocol):
    """Sees the clouds of a part of a frame as they are made, window by window."""

    def look(
        self,
        window: Window,
        thickness_m: Sequence[NDArray[np.float32]],
        shaded: NDArray[np.bool_] | None,
    ) -> None:
        """Take a window, as :meth:`hcss_twin.scene.certificate.part_sample.PartSample.look` does."""


def stream(
    plan: Plan,
    tables: RadianceTables | None,
    sample: PixelSample | None = None,
    frames: Sequence[int] | None = None,
) -> Iterator[Frame]:
    """Yield each frame's requested variables; memory does not depend on the number of frames.

    Nor does it depend on the number of points per pixel, as far as cloud generators give windows.

    Parameters
    ----------
    tables : RadianceTables or None
        None where no requested variable needs radiance.
    sample : PixelSample, optional
        Draws pixels of the frames as they are made.
    frames : sequence of int, optional
        Numbers of the frames wanted, from 0, by default all; they are those of the whole sequence.
    """
    maker = PartMaker(plan, tables)
    for index in range(plan.frame_times_s.size) if frames is None else frames:
        part = None if sample is None else sample.of_part(index)
        frame, radiance = maker.part(index, plan.extent, part)
        of_frame = None if sample is None else sample.of_frame(index)
        if part is not None and of_frame is not None:
            of_frame.add(part.drawn(radiance))
            of_frame.finish()
        yield frame


class PartMaker:
    """Makes parts of frames; those of one frame are best asked for one after the other.

    Parameters
    ----------
    plan : Plan
    tables : RadianceTables or None
        None where no requested variable needs radiance.
    """

    def __init__(self, plan: Plan, tables: RadianceTables | None) -> None:
        self._plan = plan
        self._quantities = () if tables is None else tables.quantities.names
        each = () if tables is None else tables.over_views or (tables,)
        self._readers = [TableReader(toward) for toward in each]
        self._truth = Truth(plan)
        self._shadows = Shadows(plan, tables)
        self._waves = (
            None
            if plan.waves is None
            else WaveStage(plan.waves, tables, plan.scenario.sea.wind_from, plan.samples_per_pixel)
        )
        self._bits = {
            spec.name: spec.significant_bits for spec in plan.variables if spec.significant_bits is not None
        }
        self._names = {spec.name for spec in plan.variables}
        self._temperature = (
            BrightnessTemperature(plan.spectral_grid, [band.name for band in plan.bands])
            if "brightness_temperature" in self._names
            else None
        )
        # Of the frame in hand: its number, look-up, shadows and clouds.
        self._instant: tuple[int, LookUp | ViewedLookUp | None, InstantShadows | None, FrameClouds] | None = (
            None
        )

    def part(
        self,
        index: int,
        extent: Window,
        sample: Onlooker | None = None,
        summaries: Sequence[Any] | None = None,
    ) -> tuple[Frame, NDArray[np.float32]]:
        """Return the requested variables of a part of a frame, and its radiance (Q, B, y, x) as the cube has it.

        A pixel has the same bits in every part.

        Parameters
        ----------
        index : int
            Number of the frame.
        extent : (slice, slice)
            Rows and columns of the image.
        sample : Onlooker, optional
            Draws pixels, or sees them otherwise.
        summaries : sequence, optional
            As :class:`FrameClouds` takes them.
        """
        plan, bands, time_s = self._plan, len(self._plan.bands), float(self._plan.frame_times_s[index])
        if self._instant is None or self._instant[0] != index:
            self._instant = None  # one whole frame of clouds at a time
            clouds = FrameClouds(plan, time_s, summaries)
            self._instant = index, self._look_up(time_s), self._shadows.at(time_s), clouds
        _, look_up, shadows, clouds = self._instant
        if isinstance(look_up, ViewedLookUp):
            look_up = look_up.of_part(extent)
        size = length(extent[0]), length(extent[1])
        radiance = np.empty((len(self._quantities) * bands, *size), dtype=np.float32)
        self._truth.start(*size)
        for window in windows(plan.grid, plan.samples_per_pixel, inside=extent):
            place = relative(window, extent)
            thickness = clouds.thickness_m(window)
            self._truth.fill(place, thickness)
            if look_up is not None:
                corner = place[0].start, place[1].start
                look_up.fill(radiance, thickness, plan.samples_per_pixel, corner)
            if self._waves is not None:
                self._waves.fill(radiance, self._truth.variables, window, thickness, time_s, place)
            shaded = None
            if shadows is not None:
                shaded = shadows.cast(window, thickness, radiance, self._truth.variables, place)
            if sample is not None:
                sample.look(place, thickness, shaded)
        made: Frame = dict(self._truth.variables)
        for number, name in enumerate(self._quantities):
            values = radiance[number * bands : (number + 1) * bands]
            made[TOTAL if name == TOTAL else TERM_PREFIX + name] = values
        if self._temperature is not None:
            made["brightness_temperature"] = self._temperature(made[TOTAL])
        for name, bits in self._bits.items():
            round_bits(made[name], bits)
        found = {name: values for name, values in made.items() if name in self._names}
        return found, radiance.reshape(len(self._quantities), bands, *size)

    def _look_up(self, time_s: float) -> LookUp | ViewedLookUp | None:
        """Return the look-up of an instant; None where there is no radiance."""
        look_ups = [LookUp(reader.at(time_s)) for reader in self._readers]
        if self._plan.views is not None and look_ups:
            return ViewedLookUp(self._plan.views, self._plan.grid, look_ups)
        return look_ups[0] if look_ups else None
