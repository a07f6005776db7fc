"""Notes of ``hcss match`` and ``hcss fit`` on an image of brightness temperature: its detail below the pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hcss_twin.providers import CatalogError


def image_notes(path: Path, variable: str | None) -> tuple[str, ...]:
    """Return a sentence on the detail below the pixel; none for images that are not of brightness temperature."""
    from hcss_skies.detail_of_image import described
    from hcss_skies.importing import KELVIN_RANGE, clear_sky_K, detail_of
    from hcss_skies.missing import without_missing
    from hcss_skies.planes import read_plane

    try:
        kelvin = without_missing(read_plane(path, variable, {}).kelvin, "auto")[1]
    except CatalogError:  # an entry of the database, a stack of images, or mostly missing
        return ()
    if np.any(kelvin < KELVIN_RANGE[0]) or np.any(kelvin > KELVIN_RANGE[1]):
        return ()
    return (described(detail_of(kelvin, clear_sky_K(kelvin))),)
