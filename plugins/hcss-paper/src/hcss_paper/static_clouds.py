"""Clouds of the static scenes of Table I: of measured images where the extra ``samples`` is installed, else made ones.

The satellite images of the paper (New Technology, Qilu-2) are not published.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hcss_evaluate.database.cloud_import import ImportOptions, import_image
from hcss_evaluate.database.samples import sample

from hcss_twin.models.clouds.database import CloudEntry
from hcss_twin.providers import Catalog

MADE = {"New Technology": "made-scene-30", "Qilu-2": "made-scene-47"}
"""Entries of the shipped cloud database, made by the fractal generator with the coverages of Table I."""

MEASURED = {"New Technology": "modis-cumulus", "Qilu-2": "modis-hurricane"}
"""Samples whose coverage at Otsu's threshold is closest to those of Table I."""


@dataclass(frozen=True)
class StaticClouds:
    """Clouds in place of one satellite image.

    Attributes
    ----------
    entry : CloudEntry
        Grey levels and mask.
    path : Path
        Its file.
    """

    entry: CloudEntry
    path: Path

    @property
    def coverage(self) -> float:
        """Fraction of cloudy pixels."""
        return self.entry.facts.coverage

    @property
    def scene(self) -> Mapping[str, Any]:
        """What a scenario with these clouds sets, by its keys."""
        rows, columns = self.entry.grey.shape
        return {
            "image": {"rows": rows, "columns": columns, "pixel_size": self.entry.facts.pixel_size_m},
            "motion": {"platform_speed": 0.0, "wind_speed": 0.0},
            "clouds.generator": "imagery",
            "clouds.parameters": {"entry": str(self.path)},
        }


def are_measured(catalog: Catalog) -> bool:
    """Whether the packages of the samples are installed."""
    return all(sample(name, catalog).folder is not None for name in MEASURED.values())


def in_place_of_images(catalog: Catalog) -> str:
    """Return what stands in place of the satellite images."""
    if not are_measured(catalog):
        return (
            "two entries of the shipped cloud database, made by the fractal generator with type simulated and the "
            "coverages of Table I, 400 x 400 pixels of 20 m, in place of the satellite images; with measured images: "
            "pip install 'hcss-twin[samples]'"
        )
    titles = " and ".join(f"{name} ({sample(name, catalog).title})" for name in MEASURED.values())
    return (
        f"two parts of a measured MODIS image of 2 km, {titles}, in place of the satellite images; both were "
        "chosen for their coverage at Otsu's threshold, and thickness is linear in the grey level (eq 7)"
    )


@contextmanager
def static_clouds() -> Iterator[dict[str, StaticClouds]]:
    """Yield the clouds in place of each satellite image; imported entries are in a temporary folder until then."""
    catalog = Catalog()
    with TemporaryDirectory(prefix="hcss-paper-") as folder:
        paths = {name: catalog.find(entry, CloudEntry.FOLDER, CloudEntry.SUFFIX) for name, entry in MADE.items()}
        if are_measured(catalog):
            for name, chosen in MEASURED.items():
                found = sample(chosen, catalog)
                paths[name] = Path(folder) / f"{chosen}{CloudEntry.SUFFIX}"
                import_image(found.path(), ImportOptions(**found.stated)).write(paths[name])
        yield {name: StaticClouds(CloudEntry.read(path), path) for name, path in paths.items()}
