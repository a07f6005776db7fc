"""Full disks from geostationary orbit: processor time, memory, and the certificate.

    python plugins/hcss-payload/benchmarks/disk.py --pixels 3712 --model physical            # by night, as a file
    python plugins/hcss-payload/benchmarks/disk.py --pixels 464 --time 02:30 --climate latitude
    python plugins/hcss-payload/benchmarks/disk.py --pixels 464 --time 02:30 --band mwir --accuracy 2e-2
    python plugins/hcss-payload/benchmarks/disk.py --pixels 3712 --frames                    # in memory

The disk is that of 140.7 E on 20 April 2024 with broken stratus; 14:30 is midnight there, 02:30 noon and 08:30 evening,
with the terminator. Give HCSS_CACHE_DIR an empty folder for a cold start.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import hcss_twin
from hcss_twin import Scenario


def disk(options: argparse.Namespace) -> Scenario:
    """Return the scenario of a disk."""
    printed = options.model == "as-printed"
    return Scenario.from_dict(
        {
            "seed": 3,
            "time": f"2024-04-20T{options.time}:00Z",
            "bands": [options.band],
            "accuracy": options.accuracy,
            "place": {"latitude": 0.0, "longitude": 140.7},
            "image": {"rows": 64, "columns": 64, "pixel_size": 3000.0},
            "frames": {"count": 1},
            "clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"},
            "sea": {"wind_speed": 10.0} | ({} if options.climate == "latitude" else {"temperature": 295.0}),
            "output": {"certificate": options.certificate},
            "camera": {
                "rows": options.pixels,
                "columns": options.pixels,
                "focal_length": 1.0,
                "detector_pitch": 3000.0 / 35786034.0 * 3712 / options.pixels,
                "points": options.points,
                "beyond": options.beyond,
                "climate": options.climate,
            },
            "orbit": {"provider": "geostationary", "longitude": 140.7},
            **({"radiance": {"model": "as-printed"}, "optics": {"provider": "mie"}} if printed else {}),
        }
    )


def main(options: argparse.Namespace) -> None:
    """Print what a disk costs and how accurate it is."""
    began, scenario = time.process_time(), disk(options)
    if options.frames:
        (frame,) = hcss_twin.Twin(scenario).frames()
        text = f"{frame.radiance.shape}"
    else:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(options.output or Path(folder) / "disk.nc")
            with hcss_twin.simulate(scenario, path) as cube:
                text = str(cube.attrs.get("hcss_certificate", "no certificate"))
    spent, memory = time.process_time() - began, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{spent:.0f} s processor time, {memory:.2f} GB; {text[:900]}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pixels", type=int, default=464)
    parser.add_argument("--points", type=int, default=1)
    parser.add_argument("--model", choices=("as-printed", "physical"), default="physical")
    parser.add_argument("--band", default="lwir")
    parser.add_argument("--time", default="14:30", help="UTC, hours and minutes")
    parser.add_argument("--accuracy", type=float, default=1e-3)
    parser.add_argument("--climate", choices=("place", "latitude"), default="place")
    parser.add_argument("--beyond", choices=("missing", "limb"), default="missing")
    parser.add_argument("--certificate", type=int, default=60)
    parser.add_argument("--frames", action="store_true", help="in memory, without file and certificate")
    parser.add_argument("--output", help="file of the cube; by default it is deleted")
    main(parser.parse_args())
