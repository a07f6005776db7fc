"""A run in pieces: what a killed run leaves, so that the next one goes on with the same bits.

Beside the output ``clouds.nc`` is a folder ``clouds.nc.run`` with the last state, and with the pictures and statistics
so far, one file for each time. Every file is whole or absent. The folder goes when the output is written.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hcss_skies.les.case import Case
from hcss_skies.les.model import Model
from hcss_twin.core.files import Writing
from hcss_twin.core.reading import Reading
from hcss_twin.providers import CatalogError, HcssError

_OWN = re.compile(r"state\.npz|(picture|statistics|volume)-\d{5}\.npz")

VERSION = 1
"""Version of the model: a state of another one would go on with other equations."""


class Checkpoint:
    """The folder of a run.

    Parameters
    ----------
    output : Path
        File that the run writes at its end.
    case : Case
        What it simulates.
    """

    def __init__(self, output: Path, case: Case) -> None:
        self.folder = output.with_name(output.name + ".run")
        self._case = hashlib.sha256(f"{VERSION} {case.model_dump_json()}".encode()).hexdigest()

    @property
    def _state(self) -> Path:
        return self.folder / "state.npz"

    def exists(self) -> bool:
        """Return whether there is a state to go on from."""
        return self._state.is_file()

    def start(self) -> None:
        """Make an empty folder.

        Raises
        ------
        HcssError
            If it cannot be made.
        """
        try:
            if self.folder.exists():
                self.remove()
            self.folder.mkdir()
        except OSError as error:
            raise HcssError(f"cannot make the folder {self.folder}: {error.strerror}") from error

    def save(self, model: Model) -> None:
        """Write the state."""
        numbers = np.array([model.time_s, model.step_s, model.steps, model.rain_on_sea_kg_m2])
        arrays = {
            "case": np.array(self._case),
            "numbers": numbers,
            **{f"field_{n}": f for n, f in model.fields.items()},
        }
        Writing(self._state, HcssError).arrays(arrays)

    def load(self, model: Model) -> None:
        """Set a model to the state.

        Raises
        ------
        CatalogError
            If the folder is that of another case, or damaged.
        """
        arrays = Reading(self._state, CatalogError, "not the state of a simulation").arrays()
        if str(arrays["case"]) != self._case:
            raise CatalogError(
                f"{self.folder}: is of another case, or of another version of the model; allowed: the case that it was "
                "started with. Give another name with -o, or --restart"
            )
        time_s, step_s, steps, rain = map(float, arrays["numbers"])
        model.set_state({name: arrays[f"field_{name}"] for name in model.fields}, time_s, step_s, int(steps), rain)

    def keep(self, kind: str, number: int, arrays: Mapping[str, Any]) -> None:
        """Write the picture or the statistics with a number."""
        Writing(self._part(kind, number), HcssError).arrays({name: np.asarray(a) for name, a in arrays.items()})

    def kept(self, kind: str, number: int) -> Mapping[str, Any]:
        """Read them."""
        return Reading(self._part(kind, number), CatalogError, "not a part of a simulation").arrays()

    def _part(self, kind: str, number: int) -> Path:
        return self.folder / f"{kind}-{number:05d}.npz"

    def remove(self) -> None:
        """Remove the folder.

        Raises
        ------
        HcssError
            If it has files that no run wrote: they are left as they are.
        """
        Writing.remove_orphans(self.folder)
        for path in self.folder.iterdir():
            if _OWN.fullmatch(path.name):
                path.unlink()
        try:
            self.folder.rmdir()
        except OSError as error:
            raise HcssError(f"cannot remove the folder {self.folder}: {error.strerror}; move what is in it") from error
