"""Ratios of times and their files, and the peak memory of this process."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from hcss_twin.core.errors import HcssError


class BaselineError(HcssError):
    """A file of ratios cannot be read."""


@dataclass(frozen=True)
class Ratio:
    """A measured ratio.

    Attributes
    ----------
    name : str
    value : float
        Above 0.
    better : {"lower", "higher"}
    aim : float
        Not more than this where lower is better, not less where higher is.
    what : str
        What is above and what is below.
    """

    name: str
    value: float
    better: Literal["lower", "higher"]
    aim: float
    what: str

    @property
    def reached(self) -> bool:
        """Whether the aim is."""
        return self.value <= self.aim if self.better == "lower" else self.value >= self.aim


def read_ratios(path: Path) -> dict[str, Ratio]:
    """Read ratios that :func:`write_ratios` wrote.

    Raises
    ------
    BaselineError
        If the file is missing, is not JSON, or lacks what a ratio has.
    """
    try:
        entries = json.loads(path.read_text(encoding="utf-8"))["ratios"]
        return {name: _ratio(name, entry) for name, entry in entries.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BaselineError(f"{path} holds no ratios: {error}") from error


def write_ratios(path: Path, ratios: Mapping[str, Ratio], about: Mapping[str, Any]) -> None:
    """Write ratios, and what else should be known about them, as JSON."""
    entries = {
        name: {"value": float(f"{each.value:.3g}"), "better": each.better, "aim": each.aim, "what": each.what}
        for name, each in ratios.items()
    }
    path.write_text(json.dumps({**about, "ratios": entries}, indent=1) + "\n", encoding="utf-8")


def _ratio(name: str, entry: Mapping[str, Any]) -> Ratio:
    value, better, aim = float(entry["value"]), entry["better"], float(entry["aim"])
    if better not in ("lower", "higher"):
        raise ValueError(f"{name}: better is {better!r}; allowed: lower, higher")
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name}: value {value}; allowed: above 0")
    return Ratio(name, value, better, aim, str(entry["what"]))


def peak_memory_mb() -> float:
    """Return the largest resident size since the program was started, in units of 1024^2 bytes; not on Windows.

    Linux counts what ``getrusage`` gives from the process that started this one, whose size a child has for a moment:
    the kernel's own high-water mark is that of the program alone.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) / 1024
    # imported here: Windows has none, where benchmarks do without
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak) / (1024**2 if sys.platform == "darwin" else 1024)  # bytes there, else kilobytes
