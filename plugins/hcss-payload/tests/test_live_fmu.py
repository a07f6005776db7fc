"""The FMU between a simulator and a server of live frames."""

import os
import threading
import time
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hcss_payload.live.ring import Ring, RingShape

pytest.importorskip("pythonfmu3", reason="extra fmi")


def test_a_step_asks_for_the_frame_at_its_end():
    from hcss_payload.live.fmu import POSE, LiveCamera

    name = f"hcss-test-fmu-{os.getpid()}"
    ring, asked = Ring.create(name, RingShape(4, 1, 2, 2, np.dtype(np.float32)), os.getpid()), []

    def serve():
        last, until = 0, time.monotonic() + 20.0
        while len(asked) < 2 and time.monotonic() < until:
            posted = ring.newest(last)
            if posted is not None:
                last = posted.sequence
                ring.begin(len(asked))
                ring.publish(len(asked), posted.pose_number, posted.values, time.monotonic_ns())
                asked.append(posted.values)

    ring.header["ready"] = 1
    server = threading.Thread(target=serve)
    server.start()
    try:
        camera = LiveCamera(instance_name="camera")
        camera.memory, camera.timeout_s = name, 20.0
        for key, value in zip(POSE, (7e6, 1.0, 2.0, 0.0, 0.6, 0.0, 0.8), strict=True):
            setattr(camera, key, value)
        for step in range(2):
            camera.do_step(0.5 * step, 0.5)
            assert (camera.frame, camera.frames) == (step, step + 1)
        camera.terminate()
    finally:
        server.join()
        ring.close(delete=True)
    assert asked[1].tolist() == [1.0, 7e6, 1.0, 2.0, 0.0, 0.6, 0.0, 0.8]


def test_the_fmu_describes_pose_and_frames(tmp_path):
    import hcss_payload.live.fmu
    from pythonfmu3 import FmuBuilder

    FmuBuilder.build_FMU(Path(hcss_payload.live.fmu.__file__), dest=tmp_path)
    with zipfile.ZipFile(tmp_path / "LiveCamera.fmu") as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    assert root.get("fmiVersion") == "3.0"
    kinds = {
        variable.get("name"): (variable.tag, variable.get("causality")) for variable in root.find("ModelVariables")
    }
    assert kinds.pop("time") == ("Float64", "independent")
    assert {name for name, kind in kinds.items() if kind == ("Float64", "input")} == set(hcss_payload.live.fmu.POSE)
    assert {name for name, kind in kinds.items() if kind == ("Int64", "output")} == {"frame", "frames"}
