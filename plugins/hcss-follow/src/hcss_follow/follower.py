"""How twins take new images: :func:`assimilate`, and live frames (entry point group ``hcss_payload.followers``)."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from hcss_skies.planes import read_plane
from numpy.typing import NDArray

from hcss_follow.analysis import Image, advance
from hcss_follow.state import read_state
from hcss_twin import Scenario, Twin
from hcss_twin.providers import Catalog, CatalogError, ImageError

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
            If the image does not fit, no clouds follow images, or the state cannot be written.
        """
        data = json.loads(scenario.to_json())
        layers = data["clouds"]["layers"]
        following = [layer for layer in layers if layer["generator"].rpartition("/")[2] == "followed"]
        if not following:
            of = ", ".join(layer["generator"] for layer in layers) or "none"
            raise ImageError(f"image: the scenario's generators of clouds are {of}; allowed: with followed")
        for layer in following:
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


def assimilate(twin: Twin, image: NDArray[np.floating] | Image | Path, time: datetime | None = None) -> Twin:
    """Return the twin whose sky is that of the next image; the same bits each time.

    The scenario starts when it did, so that frames have the times that they had. The state is a file beside that of the
    state before. Live frames go over to a new state by themselves.

    Parameters
    ----------
    twin : Twin
        Of a scenario with the generator `followed`; it stays as it is.
    image : ndarray (rows, columns), Image or Path
        Brightness temperature near 10.8 um, K, of the place of the state, rows northward; or a file of it.
    time : datetime
        Of the image, with its time zone; not needed where the image states it.

    Raises
    ------
    ImageError, CatalogError
        If the image does not fit, or has no time.
    """
    if isinstance(image, Path):
        image, _ = followed.read(image)
    if not isinstance(image, Image):
        if time is None:
            raise ImageError("time: that of the image is not known; allowed: a time with its time zone")
        image = Image(image, time)
    elif time is not None:
        image = replace(image, time=time)
    if image.time.tzinfo is None:
        raise ImageError(f"time: {image.time.isoformat()}; allowed: a time with its time zone")
    return Twin(followed.assimilated(twin.plan.scenario, image, image.time))
