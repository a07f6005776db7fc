"""An FMU (FMI 3.0, co-simulation) between a simulator of the satellite and a server of live frames.

``pythonfmu3 build -f fmu.py`` makes ``LiveCamera.fmu`` of this file. Its environment is that of the importing
simulator's Python, in which this package must be installed; frames stay in shared memory.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pythonfmu3 import CoSimulation, Float64, Fmi3Causality, Fmi3Slave, Fmi3StepResult, Fmi3Variability, Int64, String

POSE = ("x_m", "y_m", "z_m", "q_x", "q_y", "q_z", "q_w")


class LiveCamera(Fmi3Slave, CoSimulation):  # type: ignore[misc]  # pythonfmu3 has no types
    """Sends the pose at the end of each step to the server, and gives the number of its frame.

    Inputs are the Earth-fixed position ``x_m``, ``y_m``, ``z_m`` and the quaternion ``q_x``, ``q_y``, ``q_z``, ``q_w``
    of the body; parameters are the name of the shared memory and the longest time to wait for the server and for a
    frame; outputs are the number of the frame and how many frames there are.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.author, self.description = "The hcss_twin developers", "Live frames of hcss_twin"
        self.memory, self.timeout_s = "hcss-live", 600.0
        self.x_m = self.y_m = self.z_m = self.q_x = self.q_y = self.q_z = 0.0
        self.q_w = 1.0
        self.frame, self.frames, self.time = -1, 0, 0.0
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        parameter = {"causality": Fmi3Causality.parameter}
        self.register_variable(String("memory", variability=Fmi3Variability.fixed, **parameter))
        self.register_variable(Float64("timeout_s", variability=Fmi3Variability.fixed, **parameter))
        for name in POSE:
            self.register_variable(Float64(name, causality=Fmi3Causality.input))
        for name in ("frame", "frames"):
            self.register_variable(Int64(name, causality=Fmi3Causality.output, variability=Fmi3Variability.discrete))
        self._client: Any = None

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Ask for the frame at the end of the step, and wait for it."""
        from hcss_payload.live.client import LiveClient
        from hcss_payload.pose import Pose

        if self._client is None:
            self._client = LiveClient(self.memory, self.timeout_s)
        time_s = current_time + step_size
        values = np.array([getattr(self, name) for name in POSE])
        pose = Pose(time_s, values[:3], values[3:])
        served = self._client.wait(self._client.send_pose(pose), self.timeout_s)
        self.time = time_s
        self.frame, self.frames = served.number, self._client.counts()["frames"]
        return Fmi3StepResult()

    def terminate(self) -> None:
        """Let go of the shared memory."""
        if self._client is not None:
            self._client.close()
            self._client = None
