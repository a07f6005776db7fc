"""A pipeline for a cube, ready to run."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from hcss_pyxel.airy import airy_kernel
from hcss_pyxel.files import complete_or_absent, frame_times_s
from hcss_pyxel.radiometry import black_body_wavelength_um, etendue_m2_sr, photons
from hcss_twin import open_cube
from hcss_twin.providers import CubeError, HcssError, choose_from

FILL = 2.0 / 3.0
"""Of the well, by the brightest pixel."""


@dataclass(frozen=True)
class Instrument:
    """Instrument of the example: rounded values of a generic cooled infrared camera.

    Attributes
    ----------
    pitch_um : float
        Side of a square pixel.
    f_number, transmission, quantum_efficiency : float
        Of the optics and the detector; the Airy pattern goes by the first.
    full_well : float
        Electrons.
    bits : int
        Of the ADC.
    volts : float
        Of a full well.

    Raises
    ------
    HcssError
        If a number is not possible.
    """

    pitch_um: float = 15.0
    f_number: float = 2.0
    transmission: float = 0.8
    quantum_efficiency: float = 0.7
    full_well: float = 7e6
    bits: int = 14
    volts: float = 2.1

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            most = 1.0 if name in ("transmission", "quantum_efficiency") else 32 if name == "bits" else math.inf
            if not (0.0 < value <= most and math.isfinite(value)):
                limit = "above 0" if most == math.inf else f"above 0, at most {most:g}"
                raise HcssError(f"{name}: {value:g}; allowed: {limit}")


@dataclass(frozen=True)
class Example:
    """Files of the example: the pipeline and the kernel of its optics, with the values they were made for.

    Attributes
    ----------
    pipeline, kernel : Path
    band : str
    times_s : tuple of float
        Of reading.
    integration_time_s : float
    fill : str
        How far the brightest pixel fills the well, and what limits it.
    wavelength_um : float or None
        Mean wavelength of the scene's light in the band; None where the scene could not be computed again.
    why_not : str
        The reason for that.
    """

    pipeline: Path
    kernel: Path
    band: str
    times_s: tuple[float, ...]
    integration_time_s: float
    fill: str
    wavelength_um: float | None
    why_not: str


def write_example(
    cube: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    band: str | None = None,
    instrument: Instrument | None = None,
) -> Example:
    """Write ``pipeline.yaml`` and ``psf.npy`` for a cube to a folder, which is created if necessary.

    Parameters
    ----------
    cube : path-like
        A finished cube with radiance.
    folder : path-like
    band : str, optional
        Default: the first of the cube.
    instrument : Instrument, optional

    Raises
    ------
    CubeError
        If the cube cannot be read, has no radiance or no such band, or a file exists or cannot be written.
    """
    instrument = instrument or Instrument()
    cube, folder = Path(cube).resolve(), Path(folder).resolve()
    with open_cube(cube) as dataset:
        if "radiance" not in dataset:
            raise CubeError(f"{cube}: holds no radiance; ask for it with output.variables")
        bands = [str(name) for name in dataset["band"].to_numpy()]
        band = bands[0] if band is None else band
        if band not in bands:
            raise CubeError(f"{cube}: no band '{band}'; {choose_from(band, bands)}")
        number = bands.index(band)
        data = dataset["radiance"].isel(band=number)
        brightest = max(float(data.isel(time=index).max()) for index in range(data.sizes["time"]))
        lower, upper = (float(bound) for bound in dataset["wavelength_bounds"].to_numpy()[number])
        central = float(dataset["wavelength"].to_numpy()[number])
        first = data.isel(time=0).to_numpy().astype(np.float64)
        seconds = frame_times_s(dataset)
        rows, columns = data.sizes["y"], data.sizes["x"]
    known_um, why_not = _of_the_scene(cube, band, first)
    mean_um = known_um or float(black_body_wavelength_um(np.array([brightest]), lower, upper)[0])
    etendue = etendue_m2_sr((instrument.pitch_um * 1e-6) ** 2, instrument.f_number) * instrument.transmission
    electrons_s = instrument.quantum_efficiency * float(photons(np.array([brightest]), etendue, 1.0, mean_um)[0])
    steps = np.append(np.diff(seconds), seconds[-1] - seconds[-2]) if seconds.size > 1 else np.ones(1)
    times = tuple(round(float(time), 9) for time in seconds - seconds[0] + steps)
    longest = min(FILL * instrument.full_well / electrons_s if electrons_s > 0.0 else np.inf, steps.min())
    whole_step = longest == steps.min()
    integration = round(float(longest), 9) if whole_step else float(f"{0.95 * longest:.2g}")
    filled = electrons_s * integration / instrument.full_well
    fill = (
        f"the brightest pixel of the cube fills {filled:.0%} of the well"
        f"{', the interval of the frames allows no more' if whole_step else ''}"
    )
    pipeline, kernel = folder / "pipeline.yaml", folder / "psf.npy"
    text = Template(files("hcss_pyxel").joinpath("pipeline.yaml").read_text(encoding="utf-8")).substitute(
        frame_count=len(times),
        band=json.dumps(band),
        times=list(times),
        rows=rows,
        columns=columns,
        pitch_um=instrument.pitch_um,
        quantum_efficiency=instrument.quantum_efficiency,
        volts_per_electron=f"{instrument.volts / instrument.full_well:.3e}",
        full_well=int(instrument.full_well),
        bits=instrument.bits,
        volts=instrument.volts,
        cube=json.dumps(str(cube)),
        f_number=instrument.f_number,
        transmission=instrument.transmission,
        wavelength_um="black-body" if known_um is None else known_um,
        integration_time=repr(integration),
        fill=fill,
        time_offset=repr(float(seconds[0])),
        psf=json.dumps(str(kernel)),
    )
    existing = [path for path in (pipeline, kernel) if path.exists()]
    if existing:
        raise CubeError(f"{existing[0]} exists; give another folder, or remove it")
    folder.mkdir(parents=True, exist_ok=True)
    numbers = BytesIO()
    np.save(numbers, airy_kernel(central, instrument.f_number, instrument.pitch_um))
    with complete_or_absent(pipeline) as draft_pipeline, complete_or_absent(kernel) as draft_kernel:
        draft_pipeline.write_text(text, encoding="utf-8")
        draft_kernel.write_bytes(numbers.getvalue())
    return Example(pipeline, kernel, band, times, integration, fill, known_um, why_not)


def _of_the_scene(cube: Path, band: str, radiance: NDArray[np.float64]) -> tuple[float | None, str]:
    """Return the mean wavelength of an image from the spectra of its scene, or the reason why it is unknown."""
    from hcss_pyxel.mean_wavelength import mean_wavelengths_of

    try:
        of_bands = {band.band: band for band in mean_wavelengths_of(cube)}
    except HcssError as error:
        return None, str(error)
    if band not in of_bands:
        return None, f"the cube's scenario has no band '{band}'"
    return round(of_bands[band].of_image(radiance), 4), ""
