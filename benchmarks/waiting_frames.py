"""Rows of ``waiting.py`` that count nanoseconds: frames in one process, beside floors and peers that take turns.

    python benchmarks/waiting_frames.py [--rows stratus,sensor] [--frames 24]

Everything a row compares is asked for one frame after the other, so that all of it meets the same load. A number is
the median over frames of the processor time of all threads, or of the difference between two scenes of the same frame;
the standard error of that median stands beside it. Tables are compiled before, and nothing is written unless the row
is about writing.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

PIXELS = 512
BANDS = ["mwir-3.7", "lwir-10.8"]
AS_PRINTED = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}

Step = Callable[[], object]


@dataclass
class Comparison:
    """What a row asks for in turn.

    Attributes
    ----------
    own : callable
        Makes the next frame.
    per : float
        What a frame has of what the row counts.
    less : callable, optional
        Its time is subtracted, frame by frame.
    peers : mapping of str to (callable, float)
        Floors and peers, with what each call has of what the row counts.
    remark : str
        About what cannot be seen from the name.
    """

    own: Step
    per: float
    less: Step | None = None
    peers: Mapping[str, tuple[Step, float]] = field(default_factory=dict)
    remark: str = ""


def frames_of(scene: str, variables: Sequence[str], frames: int, **changes: Any) -> Step:
    """Return a function that computes the next frame of a scene."""
    from hcss_twin import Scenario, make_plan
    from hcss_twin.engine.compile import tables_of
    from hcss_twin.engine.stream import stream

    size = {"image.rows": PIXELS, "image.columns": PIXELS, "frames.count": frames + 2, "bands": BANDS}
    own = {name.replace("__", "."): value for name, value in changes.items() if name != "model"}
    cheap = AS_PRINTED if changes.get("model") == "as-printed" else {}
    scenario = Scenario.load(
        scene, {**size, "output.certificate": 0, "output.variables": list(variables), **cheap, **own}
    )
    plan = make_plan(scenario)
    each = stream(plan, tables_of(plan) if set(variables) != {"cloud_mask"} else None)
    return lambda: next(each)


def temperature(frames: int) -> Comparison:
    radiance = np.random.default_rng(1).uniform(7.0, 9.0, (PIXELS, PIXELS)).astype(np.float32)
    logarithm, inverse = np.linspace(0.0, 3.0, 4096), np.linspace(0.005, 0.003, 4096)
    with_it = frames_of("stratus", ["radiance", "brightness_temperature"], frames)
    return Comparison(
        with_it,
        2 * PIXELS**2,
        frames_of("stratus", ["radiance"], frames),
        {
            "numpy log and interp": (lambda: 1.0 / np.interp(np.log(radiance), logarithm, inverse), PIXELS**2),
            "copy": (lambda: radiance.copy(), PIXELS**2),
        },
        "frames with it less frames without",
    )


def stratus(frames: int) -> Comparison:
    return Comparison(frames_of("stratus", ["radiance"], frames), PIXELS**2, remark="clouds and two bands")


def waves(frames: int) -> Comparison:
    from scipy.fft import irfft2

    spectrum = np.ones((PIXELS, PIXELS // 2 + 1), np.complex64)
    return Comparison(
        frames_of("stratus", ["radiance"], frames, sea__waves="on", image__pixel_size=2),
        PIXELS**2,
        peers={"two slopes by FFT": (lambda: (irfft2(spectrum), irfft2(spectrum)), PIXELS**2)},
        remark="clouds and two bands included",
    )


def samples(frames: int) -> Comparison:
    return Comparison(
        frames_of("cirrus-over-cumulus", ["radiance"], frames, image__samples_per_pixel=3, model="as-printed"),
        9 * PIXELS**2,
        peers={"one layer, the same samples": _one_layer(frames)},
        remark="both fields and two bands included",
    )


def _one_layer(frames: int) -> tuple[Step, float]:
    own = frames_of("cumulus", ["radiance"], frames, image__samples_per_pixel=3, model="as-printed")
    return own, 9 * PIXELS**2


def mask_of(kind: str) -> Callable[[int], Comparison]:
    """Return the row of a mask, beside FastNoiseLite where it is installed."""

    def comparison(frames: int) -> Comparison:
        from cloud_contenders import Missing, fast_noise_lite, hashed_normal

        contenders = [hashed_normal]
        try:
            fast_noise_lite(kind, PIXELS, 1)
            contenders.append(fast_noise_lite)
        except Missing:
            pass
        made = [each(kind, PIXELS, 1) for each in contenders]
        peers = {each.name.removeprefix("floor: "): (each.run, PIXELS**2) for each in made}
        scene = kind if kind != "stratocumulus" else "stratus"
        return Comparison(frames_of(scene, ["cloud_mask"], frames, clouds__type=kind), PIXELS**2, peers=peers)

    return comparison


def look_up(frames: int) -> Comparison:
    from even_bits import EvenBits
    from look_up import NODES, RANGE_M, in_numpy, one_layer, sky

    from hcss_twin.engine.tables.look_up import LookUp

    nodes, thickness = np.geomspace(*RANGE_M, NODES), sky(RANGE_M, 4.0, 1)
    curve = 10.0 - 5.0 * np.exp(-np.outer(nodes, [1e-3, 4e-3, 2e-2]))
    table = one_layer(nodes, np.full(3, 4.0), curve)
    radiance = np.empty((3, *thickness.shape), np.float32)
    own, even = LookUp(table), EvenBits(table.clear[0], nodes, curve)
    LookUp(table).fill(radiance, [thickness])
    exact = radiance.copy()
    even.fill(radiance, thickness)
    error = float(np.max(np.abs(radiance / exact - 1.0)))
    return Comparison(
        lambda: own.fill(radiance, [thickness]),
        thickness.size,
        peers={
            f"axis even in bits, error {error:.0e}": (lambda: even.fill(radiance, thickness), thickness.size),
            "numpy": (lambda: in_numpy(table, thickness), thickness.size),
            "write of three planes": (lambda: radiance.fill(1.0), thickness.size),
        },
    )


def sensor(frames: int) -> Comparison:
    import dataclasses

    from hcss_author import sample_sensor_inputs
    from sensor import BLUR, NOISE, NUMBERS

    from hcss_twin.core.catalog import Catalog
    from hcss_twin.plan.sensor import make_sensor
    from hcss_twin.providers import Grid
    from hcss_twin.scenario.sensor import SensorSection

    inputs = sample_sensor_inputs()
    grid = Grid(PIXELS, PIXELS, inputs.grid.pixel_size_m)
    inputs = dataclasses.replace(inputs, bands=inputs.bands[:1], grid=grid, catalog=Catalog())
    image = np.random.default_rng(1).uniform(0.5, 2.0, (1, PIXELS, PIXELS)).astype(np.float32)
    measures = make_sensor(SensorSection(parameters={**BLUR, **NOISE, **NUMBERS}, variables=("all",)), inputs)
    random = np.random.default_rng(2)
    return Comparison(
        lambda: measures.stages[0].provider._provider.measure(image, 0, 0.0),
        PIXELS**2,
        peers={
            "the same, checked and stored": (lambda: measures.measure(image, 0, 0.0), PIXELS**2),
            "numpy normal": (lambda: random.standard_normal(PIXELS**2, dtype=np.float32), PIXELS**2),
        },
        remark="Gaussian blur of 1 pixel, noise, 14 bits",
    )


def camera(frames: int) -> Comparison:
    from scipy.fft import irfft2, rfft2

    from hcss_twin import Scenario, make_plan
    from hcss_twin.engine.compile import tables_of
    from hcss_twin.engine.scene_around import SceneAround

    size = {"image.rows": PIXELS, "image.columns": PIXELS, "frames.count": frames + 2, "bands": BANDS[:1]}
    scenario = Scenario.load(
        "stratus", {**size, "output.certificate": 0, "output.variables": ["radiance"], "sensor.name": "generic-mwir"}
    )
    plan = make_plan(scenario)
    around = SceneAround(plan, tables_of(plan), plan.sensor)
    image = np.full((1, PIXELS, PIXELS), 0.4, np.float32)
    numbers = iter(range(frames + 2))

    def own() -> None:
        number = next(numbers)
        around.sensor.measure(around.frame(number, image), number, float(number))

    wide = np.zeros(tuple(each.stop - each.start for each in around.sensor.given))
    return Comparison(
        own,
        PIXELS**2,
        peers={"FFT and back of the same area": (lambda: irfft2(rfft2(wide), s=wide.shape), PIXELS**2)},
        remark=f"Airy pattern that reaches {plan.sensor.reach} pixels; scene around the image included",
    )


def writing(**packing: str) -> Callable[[int], Comparison]:
    """Return the row of writing frames of one band and a mask, plain or packed."""

    def comparison(frames: int) -> Comparison:
        from writing import bytes_of, raw

        from hcss_twin import Scenario, make_plan
        from hcss_twin.cube.writer import CubeWriter
        from hcss_twin.engine.compile import tables_of
        from hcss_twin.engine.simulate import cube_header
        from hcss_twin.engine.stream import stream

        keys = {"frames.count": 4, "bands": ["lwir"], "output.certificate": 0} | packing
        plan = make_plan(Scenario.load("stratus", keys))
        made = list(stream(plan, tables_of(plan)))
        folder = tempfile.TemporaryDirectory(prefix="hcss-waiting-")
        cube, plain = Path(folder.name) / "cube.nc", Path(folder.name) / "raw"
        pieces = [bytes_of(frame) for frame in made]

        def own(at: tempfile.TemporaryDirectory[str] = folder) -> None:  # keeps the folder
            cube.unlink(missing_ok=True)
            with CubeWriter(cube, cube_header(plan, None)) as writer:
                for index, frame in enumerate(made):
                    writer.write_frame(index, frame)

        own()
        size = cube.stat().st_size / len(made) / made[0]["cloud_mask"].size
        return Comparison(
            own,
            len(made),
            peers={"raw write": (lambda: raw(plain, pieces)(), len(made))},
            remark=f"{size:.1f} B a pixel",
        )

    return comparison


@dataclass(frozen=True)
class FrameRow:
    """A row: its name, its aim, how to compare, and the unit."""

    name: str
    aim: str
    comparison: Callable[[int], Comparison]
    unit: str = "ns"
    scale: float = 1e9


ROWS = {
    "temperature": FrameRow("brightness temperature, per value", "1", temperature),
    "look-up": FrameRow("look-up of three bands, per pixel", "1.8", look_up),
    "sensor": FrameRow("sensor, per pixel and band", "2.5", sensor),
    "camera": FrameRow("sensor generic-mwir, per pixel and band", "2.5", camera),
    "waves": FrameRow("scene with resolved waves, per pixel", "40", waves),
    "stratus": FrameRow("scene of stratus, per pixel", "", stratus),
    "cumulus": FrameRow("mask of cumulus, per pixel", "7", mask_of("cumulus")),
    "stratocumulus": FrameRow("mask of stratocumulus, per pixel", "7", mask_of("stratocumulus")),
    "paper-simulated": FrameRow("mask of simulated, per pixel", "6", mask_of("paper-simulated")),
    "samples": FrameRow("two layers, 3 x 3 samples, per sample", "25", samples),
    "writing": FrameRow("writing of 800 x 800 pixels and one band, a frame", "", writing(), "ms", 1e3),
    "int16": FrameRow("the same as int16", "half the bytes", writing(**{"output.packing": "int16"}), "ms", 1e3),
}


def medians(comparison: Comparison, frames: int) -> tuple[float, float, dict[str, float]]:
    """Return the median of the row in seconds, its standard error, and the medians of floors and peers."""
    calls = {"own": (comparison.own, comparison.per), **comparison.peers}
    if comparison.less is not None:
        calls["less"] = comparison.less, comparison.per
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for number in range(frames + 1):  # the first compiles
        for name, (call, per) in calls.items():
            start = time.process_time()
            call()
            if number:
                seconds[name].append((time.process_time() - start) / per)
    own = np.array(seconds.pop("own")) - np.array(seconds.pop("less", [0.0]))
    deviation = 1.4826 * np.median(np.abs(own - np.median(own)))
    error = 1.25 * deviation / np.sqrt(own.size)  # of the median of normal numbers
    return float(np.median(own)), float(error), {name: float(np.median(each)) for name, each in seconds.items()}


def measured(names: Sequence[str], frames: int) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, number, aim, and floors and peers of each row."""
    for name in names:
        row = ROWS[name]
        comparison = row.comparison(frames)
        now, error, others = medians(comparison, frames)
        peers = ", ".join(f"{peer} {seconds * row.scale:.2g}" for peer, seconds in others.items())
        label = f"{row.name} ({comparison.remark})" if comparison.remark else row.name
        yield label, f"{now * row.scale:.3g} ± {error * row.scale:.1g} {row.unit}", row.aim, peers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=lambda text: text.split(","), default=list(ROWS), help=", ".join(ROWS))
    parser.add_argument("--frames", type=int, default=24)
    given = parser.parse_args()
    for row in measured(given.rows, given.frames):
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
