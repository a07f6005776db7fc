"""Tables I and III, which list inputs: bands and coverages of the static scenes, and cloud types."""

from __future__ import annotations

from hcss_paper.inputs import published
from hcss_paper.reproduction import Check, Reproduction, Row, judged
from hcss_paper.scene import BANDS
from hcss_paper.static_clouds import in_place_of_images, static_clouds
from hcss_paper.tables_8_and_9 import cloud_mask
from hcss_twin.providers import Catalog
from hcss_twin.scenario.bands import spectral_band

_HALF_A_PIXEL = 0.5 / 800**2


def table_1(seed: int) -> Reproduction:
    """Compare the printed bands and coverages with those of a simulated scene."""
    catalog = Catalog()
    bands = {spectral_band(name, catalog).name: spectral_band(name, catalog) for name in BANDS.values()}
    limits = {tuple(map(float, text.split("-"))): name for text, name in BANDS.items()}
    rows, cover_errors = [], []
    with static_clouds() as clouds:
        covers = {f"{name} Satellite": cloud.coverage for name, cloud in clouds.items()}
    for number, satellite, (low, high), coverage in published()["table_1"]["rows"]:
        band = bands[limits[low, high]]
        found = float(cloud_mask("paper-simulated", coverage, seed).mean())
        cover_errors.append(abs(found - coverage))
        label = f"Scenario{number}"
        rows += [
            Row(f"{label}, shortest wavelength", "um", low, band.lower_um),
            Row(f"{label}, longest wavelength", "um", high, band.upper_um),
            Row(f"{label}, coverage", "1", coverage, covers[satellite]),
        ]
    same = all(row.difference == 0.0 for row in rows if row.unit == "um")
    checks = (
        Check("the catalog has the three bands with the printed limits", same),
        Check(
            f"800 x 800 pixels have the requested coverage: largest difference {max(cover_errors):.1g}, at most "
            f"half a pixel, {_HALF_A_PIXEL:.1g}",
            max(cover_errors) <= _HALF_A_PIXEL,
        ),
    )
    return judged(
        rows,
        checks,
        holds="These are inputs: the bands are in the catalog, and a scene has exactly the requested coverage.",
        fails="A band or a coverage differs from the table.",
        notes=(
            f"The two satellite images are not published. Coverages are those of {in_place_of_images(catalog)}. "
            "`hcss clouds import` extracts clouds from your own images.",
            "The radiance of Table II does not follow from these coverages, but from the effective covers of "
            "opaque cloud listed there.",
        ),
    )


def table_3(seed: int) -> Reproduction:
    """Compare the printed parameters with those of the catalog's cloud types."""
    del seed  # no random numbers are used
    catalog = Catalog()
    rows = []
    for name, printed in published()["table_3"]["rows"].items():
        gamma, hurst, cells, octaves, heights_km = printed
        kept = catalog.toml(catalog.find(f"paper-{name.lower()}", "cloud_types", ".toml"))
        shape, layer = kept["fractal"], kept["layer"]
        rows += [
            Row(f"{name}, gamma", "1", gamma, float(shape["gamma"])),
            Row(f"{name}, H", "1", hurst, float(shape["H"])),
            Row(f"{name}, L along x", "1", cells[0], float(shape["L"][0])),
            Row(f"{name}, L along y", "1", cells[1], float(shape["L"][1])),
            Row(f"{name}, first k", "1", octaves[0], float(shape["k"][0])),
            Row(f"{name}, last k", "1", octaves[1], float(shape["k"][1])),
            Row(f"{name}, base", "km", heights_km[0], 1e-3 * float(layer["base"])),
            Row(f"{name}, top", "km", heights_km[1], 1e-3 * float(layer["top"])),
        ]
    largest = max(abs(row.difference or 0.0) for row in rows)
    return judged(
        rows,
        [Check(f"cloud types of the catalog: largest difference {largest:.1g}, at most 1e-12", largest <= 1e-12)],
        holds="These are inputs, and the cloud types of the catalog have the same values.",
        fails="A cloud type of the catalog differs from the table.",
        notes=(
            "The printed definition of L, the interpolation resolution, is ambiguous. It is taken as lattice cells "
            "per 16 km, which gives the density of Table VIII; pixels per cell does not.",
            "Stratocumulus (Fig 10) has no row in this table; the catalog's values are from published measurements.",
        ),
    )
