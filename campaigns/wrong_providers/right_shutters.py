"""Right sensors that ask for the scene at other instants."""

import numpy as np
from right_kit import kit

from hcss_twin.providers import Measured, SensorDeclaration

from hcss_examples import rolling_shutter  # isort: skip


class Exposure:
    """Mean over an exposure that begins with the frame."""

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)
    instants = 0.0, 0.05

    def __init__(self, inputs):
        self._inputs = inputs

    def measure(self, radiance, frame, time_s):
        grid = self._inputs.grid
        whole = slice(0, grid.rows), slice(0, grid.columns)
        times = time_s + self.instants[1] * (np.arange(5) + 0.5) / 5.0
        return Measured(np.mean([self._inputs.scene_at(time, *whole) for time in times.tolist()], axis=0))


class Jitter:
    """Frames that are taken a little early or late, at random."""

    variables = ()
    declares = SensorDeclaration(reach_pixels=0)
    instants = -0.01, 0.01

    def __init__(self, inputs):
        self._inputs = inputs

    def measure(self, radiance, frame, time_s):
        random = np.random.default_rng((self._inputs.seed, frame))
        late = float(np.clip(random.normal(0.0, 0.003), *self.instants))
        return Measured(self._inputs.scene_at(time_s + late, slice(0, radiance.shape[1]), slice(0, radiance.shape[2])))


def rows_later(self, inputs):
    late = 1e-4 * (inputs.corner[0] + np.arange(inputs.grid.rows))
    return np.broadcast_to(late[:, None], (inputs.grid.rows, inputs.grid.columns))


def half_the_exposure(self, inputs):
    return np.full((inputs.grid.rows, inputs.grid.columns), 0.025)


def sensors():
    shutter = lambda inputs: rolling_shutter.RollingShutter(inputs, rolling_shutter.Parameters())  # noqa: E731
    yield (
        "rolling-shutter",
        "sensors",
        "rows that are read one after the other",
        kit("sensors", shutter, known_delay_s=rows_later),
    )
    yield "exposure", "sensors", "the mean over an exposure", kit("sensors", Exposure, known_delay_s=half_the_exposure)
    yield "jitter", "sensors", "frames that are early or late", kit("sensors", Jitter)
