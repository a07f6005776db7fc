"""A cloud type of a test's own: that of the catalog for the paper's stratus, with other particles."""

from __future__ import annotations

from pathlib import Path

from hcss_twin.core.catalog import Catalog

BY_SHAPE = "alpha = 3.0\nb = 0.193  # um^-nu\nnu = 1.30\nnumber_density = 80.0e6  # m-3\nradius_range_um = [0.02, 50.0]"
"""Particles of stratus in the catalog."""


def own_type(folder: Path, microphysics: str, material: str = "water") -> Catalog:
    """Write the type ``mine.toml``, and return the catalog that has it."""
    text = (Catalog().root / "cloud_types" / "paper-stratus.toml").read_text(encoding="utf-8")
    assert BY_SHAPE in text
    text = text.replace(BY_SHAPE, microphysics).replace('material = "water"', f'material = "{material}"')
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    return Catalog(base=folder)
