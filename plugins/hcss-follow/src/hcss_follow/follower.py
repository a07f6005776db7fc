"""How live frames of a followed sky take new images (entry point group ``hcss_payload.followers``)."""

from __future__ import annotations

import json
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hcss_skies.planes import read_plane

from hcss_follow.analysis import Image, advance
from hcss_follow.state import read_state
from hcss_twin import Scenario
from hcss_twin.providers import Catalog, CatalogError

_TIME = re.compile(r"(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d(?::\d\d)?)")


class Follower:
    """Images of files and their states."""

    def read(self, path: Path) -> tuple[Image, datetime]:
        """Return an image and its time.

        Raises
        ------
        CatalogError
            If the file is no image, or does not state its time.
        """
        plane = read_plane(path, None, {})
        found = _TIME.search(plane.source)
        if found is None:
            raise CatalogError(f"{path}: the file does not state its time; allowed: files that do")
        time = datetime.fromisoformat(f"{found[1]}T{found[2]}").replace(tzinfo=UTC)
        return Image(plane.kelvin, time), time

    def assimilated(self, scenario: Scenario, image: Any, time: datetime) -> Scenario:
        """Return the scenario after an image; its state file is beside that of the state before.

        Parameters
        ----------
        image : Image or ndarray (rows, columns)
            Brightness temperature near 10.8 um, of the place of the state.

        Raises
        ------
        ImageError, CatalogError
            If the image does not fit, or the state cannot be written.
        """
        data = json.loads(scenario.to_json())
        for layer in data["clouds"]["layers"]:
            if layer["generator"].rpartition("/")[2] != "followed":
                continue
            parameters = layer["parameters"]
            path = Catalog(base=scenario.base).file(parameters["state"])
            before = read_state(path)
            state = advance(before, image if isinstance(image, Image) else Image(image, time))
            stem = path.stem.removesuffix(f"-{before.number}")
            written = path.with_name(f"{stem}-{state.number}.nc").resolve()
            state.write(written)
            lead_s = (scenario.time - state.time).total_seconds()
            layer["parameters"] = parameters | {"state": str(written), "lead": lead_s}
        return Scenario.from_dict(data, base=scenario.base, origin=scenario.origin)


followed = Follower()
