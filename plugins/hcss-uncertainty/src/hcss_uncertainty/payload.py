"""What the sensor of a scene makes of its frames, and its noise: the difference of two sensors with different seeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.scene_around import SceneAround
from hcss_twin.engine.tables.radiance_tables import RadianceTables
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import Array

MEASURED, NUMBER, SATURATED = "measured_radiance", "digital_number", "saturated_fraction"

_FAMILY = 2**18 + 1
"""Separates the seed of the second sensor from all others."""


class Payload:
    """The sensor of a plan that has one, and a second one that differs in its seeds alone.

    Half the mean square difference of their measurements of one scene is the variance of the noise, of any sensor
    model: random noise and fixed pattern together, with what saturation and quantisation leave of them.
    """

    DIFFERENCE = "difference"
    """Measured radiance less that of the second sensor."""

    AUXILIARY = DIFFERENCE, SATURATED
    """Measured values whose pixels are not summarised as such."""

    def __init__(self, plan: Plan, tables: RadianceTables) -> None:
        sensor = plan.sensor
        assert sensor is not None
        whole = sensor.measuring(tuple(name for stage in sensor.stages for name in stage.provider.variables))
        base = sensor.stages[0].seed
        family = np.random.SeedSequence(base, spawn_key=(_FAMILY,))
        other = whole.reseeded(int(family.generate_state(1, np.uint64)[0] >> np.uint64(1)))
        self._slope = sensor.radiance_per_kelvin
        self._one, self._other = (SceneAround(plan, tables, scenario) for scenario in (whole, other))
        self._first, self._times_s = plan.scenario.frames.first, plan.frame_times_s
        self._names, self._bands = [spec.name for spec in whole.variables], whole.inputs.bands

    def measure(self, index: int, radiance: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
        """Return measured radiance, digital number and saturation, where the sensor has them, and ``DIFFERENCE``.

        Parameters
        ----------
        index : int
            Number of the frame, from 0; frames in order.
        radiance : ndarray of float32 (B, y, x)
            Clean radiance of the frame.
        """
        scene, points = self._one.frame(index, radiance)
        frame, time_s = self._first + index, float(self._times_s[index])
        one, other = (around.sensor.measure(scene, frame, time_s, points) for around in (self._one, self._other))
        found: dict[str, NDArray[Any]] = {MEASURED: one["radiance"]}
        if "digital_number" in self._names:
            found[NUMBER] = one["digital_number"]
        if "saturated" in self._names:
            found[SATURATED] = one["saturated"] > 0
        return found | {self.DIFFERENCE: one["radiance"].astype(np.float64) - other["radiance"]}

    def with_figures_of_merit(self, moments: Mapping[str, Array], square: Array) -> dict[str, Array]:
        """Return moments of each band and class (band, class) with noise, signal-to-noise ratio and NEDT.

        ``square`` (band, class) is the mean square of ``DIFFERENCE``. The signal-to-noise ratio is NaN without noise.
        The NEDT is the noise divided by the slope of the band radiance of a black body at the brightness temperature of
        the class.
        """
        found = {name: values for name, values in moments.items() if not name.startswith(self.AUXILIARY)}
        if SATURATED in moments:
            found[SATURATED] = moments[SATURATED]
        noise = np.sqrt(0.5 * square)
        slope = np.full(noise.shape, np.nan)
        for band, kelvin, band_slope in zip(self._bands, moments["brightness_temperature"], slope, strict=True):
            for pixel in np.flatnonzero(np.isfinite(kelvin)):
                band_slope[pixel] = self._slope(band, float(kelvin[pixel]))
        ratio = np.divide(moments[MEASURED], noise, out=np.full(noise.shape, np.nan), where=noise > 0.0)
        return found | {"noise_radiance": noise, "signal_to_noise": ratio, "nedt": noise / slope}
