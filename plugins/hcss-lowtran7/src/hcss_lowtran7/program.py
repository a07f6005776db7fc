"""Run the compiled LOWTRAN7, each run in a separate folder."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hcss_lowtran7.build import Program
from hcss_twin.providers import ProviderError

Array = NDArray[np.float64]

STEP_CM1 = 5.0
TRANSMITTANCE, RADIANCE, AS_IT_IS, AIR = range(4)
"""What the driver is asked for; see driver.f90."""

_TIMEOUT_S = 600.0


@dataclass(frozen=True)
class Job:
    """One path: the requested quantity, and a deck of cards for each leg."""

    wanted: int
    decks: tuple[str, ...]


@dataclass(frozen=True)
class Output:
    """Output of one run: the stream of reals, and the listing TAPE7 of the last leg."""

    numbers: Array
    tape7: str


def spectra(program: Program, jobs: Sequence[Job], first_cm1: float, last_cm1: float) -> Array:
    """Return transmittance or radiance (jobs, V) at every 5 cm-1 from first to last.

    Raises
    ------
    ProviderError
        If LOWTRAN7 fails on a path.
    """
    count = round((last_cm1 - first_cm1) / STEP_CM1) + 1
    output = run(program, jobs, first_cm1, last_cm1)
    if output.numbers.size != count * len(jobs):
        raise ProviderError(
            f"lowtran7: the program returned {output.numbers.size} numbers; expected {count * len(jobs)}"
        )
    return output.numbers.reshape(len(jobs), count)


def run(program: Program, jobs: Sequence[Job], first_cm1: float, last_cm1: float) -> Output:
    """Run jobs in one process.

    Raises
    ------
    ProviderError
        If the program cannot be started, fails, or gives up a path.
    """
    with tempfile.TemporaryDirectory(prefix="hcss-lowtran7-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        _write_inputs(folder, jobs, first_cm1, last_cm1)
        try:
            done = subprocess.run(
                [str(program.path)],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=_TIMEOUT_S,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise ProviderError(
                f"lowtran7: running {program.path} failed: {error}; delete that file to have it compiled again"
            ) from error
        failed = folder / "FAILED"
        if failed.is_file():
            path, leg = map(int, failed.read_text().split())
            cards = jobs[path - 1].decks[leg - 1].splitlines()
            raise ProviderError(f"lowtran7: LOWTRAN7 cannot trace the path of card 3, '{cards[-3].strip()}'")
        # A STOP inside LOWTRAN7 exits with status 0: what counts is that all results are there.
        result = folder / "RESULT"
        if done.returncode != 0 or not result.is_file():
            said = " ".join((done.stderr + done.stdout).split())[-400:]
            raise ProviderError(f"lowtran7: the program ended with status {done.returncode}: {said}")
        numbers = np.fromfile(result, dtype=program.precision).astype(np.float64)
        return Output(numbers, (folder / "out" / "TAPE7").read_text(errors="replace"))


def _write_inputs(folder: Path, jobs: Sequence[Job], first_cm1: float, last_cm1: float) -> None:
    (folder / "out").mkdir()
    for tape in ("TAPE6", "TAPE7", "TAPE8"):
        (folder / "out" / tape).touch()  # LOWTRAN7 opens them with STATUS='OLD'
    (folder / "TAPE5").write_text("".join(card for job in jobs for card in job.decks))
    lines = [f"{first_cm1:.1f} {last_cm1:.1f} {len(jobs)}"]
    lines += [f"{job.wanted} {len(job.decks)}" for job in jobs]
    (folder / "JOBS").write_text("\n".join(lines) + "\n")
