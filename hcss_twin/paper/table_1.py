"""Table I: the six static scenes, which are inputs."""

from __future__ import annotations

from hcss_twin.core.catalog import Catalog
from hcss_twin.paper.cloud_images import cloud_mask
from hcss_twin.paper.item import Check, Reproduction, Row
from hcss_twin.paper.published import published
from hcss_twin.paper.scene import BANDS
from hcss_twin.paper.verdict import judged
from hcss_twin.scenario.bands import spectral_band

_HALF_A_PIXEL = 0.5 / 800**2


def table_1(seed: int) -> Reproduction:
    """Return the printed bands and coverages beside those a scene gets."""
    catalog = Catalog()
    bands = {spectral_band(name, catalog).name: spectral_band(name, catalog) for name in BANDS.values()}
    limits = {tuple(map(float, text.split("-"))): name for text, name in BANDS.items()}
    rows, cover_errors = [], []
    for number, _, (low, high), coverage in published()["table_1"]["rows"]:
        band = bands[limits[low, high]]
        found = float(cloud_mask("simulated", coverage, seed).mean())
        cover_errors.append(abs(found - coverage))
        label = f"Scenario{number}"
        rows += [
            Row(f"{label}, shortest wavelength", "um", low, band.lower_um),
            Row(f"{label}, longest wavelength", "um", high, band.upper_um),
            Row(f"{label}, coverage", "1", coverage, found),
        ]
    same = all(row.difference == 0.0 for row in rows if row.unit == "um")
    checks = (
        Check("the catalog has the three bands with the printed limits", same),
        Check(
            f"800 x 800 pixels have the coverage asked for: largest difference {max(cover_errors):.1g}, at most "
            f"half a pixel, {_HALF_A_PIXEL:.1g}",
            max(cover_errors) <= _HALF_A_PIXEL,
        ),
    )
    return judged(
        rows,
        checks,
        holds="These are inputs: the bands are in the catalog, and a scene gets exactly the coverage it asks for.",
        fails="A band or a coverage is not what the table says.",
        notes=(
            "The two satellite images are not published. Coverages are of clouds of type simulated; an image of "
            "one's own becomes a scene with `hcss clouds`.",
            "The radiance of Table II does not follow from these coverages: it fits effective covers of opaque "
            "cloud, which are listed there.",
        ),
    )
