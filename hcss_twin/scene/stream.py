"""Frames: thickness from the generators, radiance by look-up, one after the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.cube.bit_rounding import round_bits
from hcss_twin.cube.variables import TERM_PREFIX
from hcss_twin.scene.brightness import BrightnessTemperature
from hcss_twin.scene.certificate.certificate_pixels import FrameSample, PixelSample
from hcss_twin.scene.footprint import points_of, windows
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.slant.shadows import Shadows
from hcss_twin.scene.tables.look_up import LookUp
from hcss_twin.scene.tables.radiance_tables import TOTAL, RadianceTables, TableReader
from hcss_twin.scene.truth import Truth
from hcss_twin.scene.views.viewed_look_up import ViewedLookUp
from hcss_twin.scene.waves.waves import WaveStage

Frame = dict[str, NDArray[Any]]
Thickness = NDArray[np.float32]


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
    maker = _FrameMaker(plan, tables)
    for index in range(plan.frame_times_s.size) if frames is None else frames:
        time_s = float(plan.frame_times_s[index])
        yield maker.frame(time_s, None if sample is None else sample.of_frame(index))


class _FrameMaker:
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

    def frame(self, time_s: float, sample: FrameSample | None) -> Frame:
        plan, bands = self._plan, len(self._plan.bands)
        look_up = self._look_up(time_s)
        shape = len(self._quantities) * bands, plan.grid.rows, plan.grid.columns
        radiance = np.empty(shape, dtype=np.float32)
        self._truth.start_frame()
        shadows = self._shadows.at(time_s)
        whole = self._whole_frames(time_s)
        for window in windows(plan.grid, plan.samples_per_pixel):
            thickness = self._thickness(time_s, window, whole)
            self._truth.fill(window, thickness)
            if look_up is not None:
                corner = window[0].start, window[1].start
                look_up.fill(radiance, thickness, plan.samples_per_pixel, corner)
            if self._waves is not None:
                self._waves.fill(radiance, self._truth.variables, window, thickness, time_s)
            shaded = None
            if shadows is not None:
                shaded = shadows.cast(window, thickness, radiance, self._truth.variables)
            if sample is not None:
                sample.look(window, thickness, shaded)
        made: Frame = dict(self._truth.variables)
        for index, name in enumerate(self._quantities):
            values = radiance[index * bands : (index + 1) * bands]
            made[TOTAL if name == TOTAL else TERM_PREFIX + name] = values
        if self._temperature is not None:
            made["brightness_temperature"] = self._temperature(made[TOTAL])
        for name, bits in self._bits.items():
            round_bits(made[name], bits)
        if sample is not None:
            # of what the cube has
            sample.finish(radiance.reshape(len(self._quantities), bands, *radiance.shape[1:]))
        return {name: values for name, values in made.items() if name in self._names}

    def _look_up(self, time_s: float) -> LookUp | ViewedLookUp | None:
        """Return the look-up of an instant; None where there is no radiance."""
        look_ups = [LookUp(reader.at(time_s)) for reader in self._readers]
        if self._plan.views is not None and look_ups:
            return ViewedLookUp(self._plan.views, self._plan.grid, look_ups)
        return look_ups[0] if look_ups else None

    def _whole_frames(self, time_s: float) -> list[Thickness | None]:
        """Frames of the generators that only make whole ones."""
        plan, samples = self._plan, self._plan.samples_per_pixel
        rows, columns = (slice(0, size * samples) for size in (plan.grid.rows, plan.grid.columns))
        return [
            None if generator.declares.tileable else generator.thickness_m(time_s, rows, columns)
            for generator in plan.generators
        ]

    def _thickness(
        self, time_s: float, window: tuple[slice, slice], whole: Sequence[Thickness | None]
    ) -> list[Thickness]:
        """Thickness of each layer at the points of a window."""
        rows, columns = (points_of(pixels, self._plan.samples_per_pixel) for pixels in window)
        return [
            generator.thickness_m(time_s, rows, columns) if frame is None else frame[rows, columns]
            for generator, frame in zip(self._plan.generators, whole, strict=True)
        ]
