"""Measured sample images: files of other packages, which the extra ``samples`` of this package installs.

No image is shipped: ``catalogs/samples`` names the file, its part without land, its source and its licence.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from hcss_twin.providers import Catalog, CatalogError, choose_from

FOLDER = "samples"
"""Folder of the catalog, and name of the extra that installs the images."""


@dataclass(frozen=True)
class Sample:
    """One measured image.

    Attributes
    ----------
    title : str
        What it shows.
    package, file : str
        Python package that carries the image, and path in the folder of that package.
    sha256 : str
        Hash of the file.
    crop : list of int
        First row, first column, rows and columns of the part to use, counted as stored.
    band, observed, source, licence : str
        As in :class:`hcss_twin.models.clouds.database.CloudEntry.Facts`.
    pixel_size_m : float or None
        Where the file gives none.
    """

    title: str
    package: str
    file: str
    sha256: str
    crop: list[int]
    band: str
    observed: str
    source: str
    licence: str
    pixel_size_m: float | None = None

    @property
    def folder(self) -> Path | None:
        """Folder of the package; None if it is not installed. The package is not imported."""
        spec = find_spec(self.package.replace("-", "_"))
        places = None if spec is None else spec.submodule_search_locations
        return Path(places[0]) if places else None

    @property
    def stated(self) -> dict[str, Any]:
        """What the sample states of the options of an import, by their names."""
        names = ("pixel_size_m", "band", "observed", "source", "licence")
        return {"crop": tuple(self.crop), **{name: getattr(self, name) for name in names}}

    def path(self) -> Path:
        """Return the image file.

        Raises
        ------
        CatalogError
            If the package is not installed, or holds another file.
        """
        if self.folder is None:
            raise CatalogError(
                f"'{self.title}' is an image of the package {self.package}, which is not installed: "
                f"pip install 'hcss-twin[{FOLDER}]'"
            )
        path = self.folder / self.file
        if not path.is_file() or hashlib.sha256(path.read_bytes()).hexdigest() != self.sha256:
            raise CatalogError(f"{path}: not the image that '{self.title}' is a part of; update {self.package}")
        return path


def samples(catalog: Catalog) -> dict[str, Sample]:
    """Return all samples by name, installed or not."""
    names = catalog.names(FOLDER, ".toml")
    return {name: Sample(**catalog.toml(catalog.find(name, FOLDER, ".toml"))) for name in names}


def sample(name: str, catalog: Catalog) -> Sample:
    """Return a sample by name.

    Raises
    ------
    CatalogError
        If there is none; the message lists the names.
    """
    known = samples(catalog)
    if name not in known:
        raise CatalogError(f"no sample '{name}'; {choose_from(name, known)}")
    return known[name]
