"""Peak memory of the cloud field, and of a whole simulation, for few and for many frames.

Each number is the peak resident size of a process of its own. Frames are small, so that 5000 of them take a minute;
what must not grow is the difference between the rows.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from regression import peak_memory_mb

PIXELS = 128
FRAMES = (8, 5000)


def memory(kind: str) -> None:
    """Print peak resident memory in MB."""
    print(f"{kind}, {PIXELS} x {PIXELS} pixels; peak resident memory, MB\n")
    print("| frames | " + " | ".join(str(count) for count in FRAMES) + " |")
    print("|---|" + "---|" * len(FRAMES))
    for task, title in (("field", "field alone"), ("cube", "simulation into a cube, 1 band and cloud thickness")):
        peaks = []
        for count in FRAMES:
            command = [sys.executable, __file__, task, kind, str(count)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            last = done.stderr.strip().splitlines()[-1:] or ["no message"]
            peaks.append(f"{float(done.stdout.split()[-1]):.0f}" if done.returncode == 0 else last[0])
        print(f"| {title} | " + " | ".join(peaks) + " |")


def child(task: str, kind: str, frames: int) -> None:
    """Do one task and print the peak resident size in MB."""
    if task == "field":
        from cloud_scenes import MOTION, make_generator

        generator, window = make_generator(kind, PIXELS), slice(0, PIXELS)
        for frame in range(frames):
            generator.field(frame * MOTION.frame_interval_s, window, window)
    else:
        import hcss_twin

        scenario = hcss_twin.Scenario.load(
            "stratus",
            {
                "clouds.type": kind,
                "image.rows": PIXELS,
                "image.columns": PIXELS,
                "frames.count": frames,
                # Close frames: the sun must stay up for all of them.
                "frames.interval": 0.1,
                "bands": ["lwir"],
                "output.variables": ["radiance", "cloud_thickness"],
            },
        )
        with tempfile.TemporaryDirectory() as folder:
            hcss_twin.simulate(scenario, Path(folder) / "cube.nc").close()
    print(peak_memory_mb())


if __name__ == "__main__":
    child(sys.argv[1], sys.argv[2], int(sys.argv[3]))
