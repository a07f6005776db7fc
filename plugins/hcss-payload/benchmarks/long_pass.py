"""A pass of 10 minutes at 10 Hz with 512 x 512 pixels and two bands: time, memory, certificate, geolocation, jitter.

    python plugins/hcss-payload/benchmarks/long_pass.py --frames 10
    python plugins/hcss-payload/benchmarks/long_pass.py --frames 6000    # all of it

Fewer frames than 6000 are spread over the same pass: tables and certificate are those of the whole, and the time of a
frame is what a longer run costs more. The file is compressed (zlib level 1, radiance rounded to 2e-4 of itself).
Memory is that of the process (Linux) when a twentieth of the file was written, a half, and nearly all: clouds keep up
to 256 MiB of their lattice, which the first frames fill. A line every five minutes tells how far a run is. Geolocation
compares latitude and longitude of random pixels of the cube with PROJ (which the extra ``test`` installs), along lines
of sight from the position and quaternion in the cube. Jitter is compared with its spectrum in each octave.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import xarray
from hcss_payload import Camera, Jitter
from scipy.integrate import trapezoid
from scipy.spatial.transform import Rotation

import hcss_twin
from hcss_twin import Scenario
from hcss_twin.core.arrays import Array

MINUTES, RATE_HZ, FOCAL_M, PITCH_M = 10.0, 10.0, 0.15, 1.5e-5
JITTER_RAD = (2e-5, 2e-5, 1e-5)


def scene(options: argparse.Namespace) -> Scenario:
    """Return the scenario of a pass by day over broken clouds, zenith about 70, 35 and 66 degrees."""
    printed = options.model == "as-printed"
    return Scenario.from_dict(
        {
            "seed": 3,
            "time": "2024-04-20T02:30:00Z",
            "bands": ["lwir", "mwir"],
            "accuracy": options.accuracy,
            "place": {"latitude": 30.0, "longitude": 150.0},
            "image": {"rows": 64, "columns": 64, "pixel_size": 100.0},
            "frames": {"count": options.frames, "interval": 60.0 * MINUTES / max(1, options.frames - 1)},
            "clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"},
            "sea": {"wind_speed": 10.0, "temperature": 295.0},
            "output": {"certificate": options.certificate, "compression": 1, "quantization": 2e-4},
            "camera": {
                "rows": options.pixels,
                "columns": options.pixels,
                "focal_length": FOCAL_M,
                "detector_pitch": PITCH_M,
                "points": options.points,
            },
            "orbit": {
                "provider": "circular",
                "altitude": 1.3e6,
                "inclination": 98.2,
                "above": [30.0, 157.5],
                "above_time": 29.0 * MINUTES,
            },
            "attitude": {"provider": "track"},
            "jitter": {"rms": list(JITTER_RAD)},
            **({"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}} if printed else {}),
        }
    )


def geolocation_m(cube: xarray.Dataset, pixels: int) -> float:
    """Return the largest distance between places of pixels and where PROJ finds them, at right angles to the ray, m."""
    import pyproj

    to_earth = pyproj.Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    camera = Camera(cube.sizes["row"], cube.sizes["column"], FOCAL_M, PITCH_M)
    rng, worst = np.random.default_rng(1), 0.0
    for number in range(cube.sizes["time"]):
        frame = cube.isel(time=number)
        row, column = (rng.integers(cube.sizes[name], size=pixels) for name in ("row", "column"))
        places = [frame[f"pixel_{name}"].values[row, column] for name in ("longitude", "latitude")]
        place = np.stack(to_earth.transform(*places, np.zeros(pixels)), axis=-1)
        turn = Rotation.from_quat(frame["platform_quaternion"].values)
        ray = turn.apply(camera.directions(row.astype(float), column.astype(float)))
        away = place - frame["platform_position"].values
        off = away - np.sum(away * ray, axis=-1, keepdims=True) * ray
        worst = max(worst, float(np.linalg.norm(off, axis=-1).max()))
    return worst


class Progress(threading.Thread):
    """Notes memory (GB), processor time (s) and what is written of a file (GB) every half second, until stopped."""

    def __init__(self, path: Path) -> None:
        super().__init__(daemon=True)
        self._path, self._end, self.notes = path, threading.Event(), [(0.0, 0.0, 0.0)]

    def run(self) -> None:
        """Take notes."""
        page = resource.getpagesize() / 1e9
        while not self._end.wait(0.5):
            # A file has its final size from the beginning; blocks of 512 bytes tell what is written.
            if written := [512 * each.stat().st_blocks for each in self._path.parent.iterdir() if each.is_file()]:
                memory = page * int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
                self.notes.append((memory, time.process_time(), max(written) / 1e9))
                if len(self.notes) % 600 == 0:
                    print(
                        f"{memory:.3f} GB, {time.process_time():.0f} s of processor time, {max(written) / 1e9:.2f} GB"
                    )

    def stop(self) -> None:
        """End, and print memory over the file, and the time of what was written between a twentieth and nearly all."""
        self._end.set()
        self.join()
        memory, spent, size = np.array(self.notes).T
        at = [int(np.argmax(size >= share * size[-1])) for share in (0.05, 0.5, 0.98)]
        rest = (spent[at[2]] - spent[at[0]]) / (size[at[2]] - size[at[0]]) if size[at[2]] > size[at[0]] else np.nan
        each = ", ".join(f"{memory[number]:.3f}" for number in at)
        print(
            f"memory {each} GB after 5, 50 and 98 % of {size[-1]:.2f} GB; {rest:.1f} s of processor time a GB between"
        )


def octaves_off(jitter: Jitter) -> Array:
    """Return the largest relative error of the power of each octave from 0.1 Hz on, over the axes."""
    rate, count = 400.0, 2**18
    turns, window = jitter.at(np.arange(count) / rate), np.hanning(count)
    power = np.abs(np.fft.rfft(turns * window[:, None], axis=0)) ** 2 * 2.0 / np.sum(window**2) / rate
    frequency = np.fft.rfftfreq(count, 1.0 / rate)
    whole = np.geomspace(jitter.lowest_hz, jitter.highest_hz, 100_001)
    errors = []
    for low in jitter.lowest_hz * 2.0 ** np.arange(int(np.log2(jitter.highest_hz / jitter.lowest_hz))):
        inside = whole[(whole >= low) & (whole <= 2.0 * low)]
        share = trapezoid(inside**-jitter.exponent, inside) / trapezoid(whole**-jitter.exponent, whole)
        own = np.sum(power[(frequency >= low) & (frequency < 2.0 * low)], axis=0) * frequency[1]
        errors.append(np.abs(own / (share * np.array(jitter.rms_rad) ** 2) - 1.0).max())
    return np.array(errors)


def main(options: argparse.Namespace) -> None:
    """Print what the pass costs and how accurate it is."""
    began, scenario = time.process_time(), scene(options)
    plan = hcss_twin.make_plan(scenario)
    planned = time.process_time() - began
    views = f"{plan.views.order_x + 1} x {plan.views.order_y + 1} directions"
    print(f"plan {planned:.0f} s processor time, {views}, {plan.samples_per_pixel} points along a pixel")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pass.nc"
        progress = Progress(path)
        progress.start()
        with hcss_twin.simulate(scenario, path) as cube:
            progress.stop()
            spent = time.process_time() - began - planned
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            size = path.stat().st_size / options.frames / 1e6
            print(
                f"tables, {options.frames} frames and certificate {spent:.0f} s; {memory:.2f} GB; {size:.1f} MB a frame"
            )
            zenith = cube["pixel_view_zenith"].isel(time=[0, options.frames // 2, -1], row=0, column=0).values
            print(f"zenith {zenith.round(1)} deg; {str(cube.attrs.get('hcss_certificate', 'no certificate'))[:200]}")
            print(f"geolocation against PROJ: {geolocation_m(cube, 200):.2g} m at most")
    print(f"power of jitter, error in octaves from 0.1 Hz: {octaves_off(Jitter(JITTER_RAD)).round(3)}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--pixels", type=int, default=512)
    parser.add_argument("--points", type=int, default=2)
    parser.add_argument("--model", choices=("as-printed", "physical"), default="as-printed")
    parser.add_argument("--accuracy", type=float, default=1e-3)
    parser.add_argument("--certificate", type=int, default=24)
    main(parser.parse_args())
