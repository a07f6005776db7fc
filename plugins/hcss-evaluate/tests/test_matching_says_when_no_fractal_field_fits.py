"""A match says whether a fractal field can look like the image: a Gaussian field can, streets and cells cannot."""

from __future__ import annotations

import importlib.metadata
import types

import numpy as np
import pytest
from hcss_evaluate.matching import target as target_module
from hcss_evaluate.matching.match import match
from hcss_evaluate.matching.search import reference_cells
from hcss_evaluate.matching.structure import CloudImage, simulate_image
from hcss_evaluate.matching.target import Target, read_target
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from hcss_twin.core.plugins import Origin
from hcss_twin.models.clouds.fractal.parameters import FractalParameters

SIDE, BUDGET = 96, 48
LIKE = CloudImage(np.zeros((SIDE, SIDE), np.float32), 1000.0)
SAYING = "no fractal field looks like this image"


def says_so(image: CloudImage) -> bool:
    unmatched = match(Target(image, "image", ()), budget=BUDGET).unmatched
    return any(line.startswith(SAYING) for line in unmatched)


@pytest.mark.parametrize(("hurst", "cells"), [(0.3, (8.0, 8.0)), (0.6, (5.0, 12.0))], ids=str)
def test_a_fractal_field_looks_like_its_match(hurst: float, cells: tuple[float, float]) -> None:
    shape = FractalParameters(gamma=2.0, H=hurst, L=reference_cells(np.array(cells), LIKE), k=(0, 4))
    assert not says_so(simulate_image(shape, 0.4, LIKE, 5))


def grey(field: np.ndarray) -> CloudImage:
    level = np.where(field > 0.0, 1.0 + 254.0 * field / field.max(), 0.0)
    return CloudImage(level.astype(np.float32), 1000.0)


def streets() -> np.ndarray:
    y, x = np.mgrid[:SIDE, :SIDE]
    return np.sin(2.0 * np.pi * (y / 9.0 + 0.3 * np.sin(x / 30.0))) - 0.2 + 0.2 * np.sin(x / 7.0 + y / 23.0)


def open_cells() -> np.ndarray:
    places = np.random.default_rng(2).uniform(0.0, SIDE, (60, 2))
    near = cKDTree(places).query(np.stack(np.mgrid[:SIDE, :SIDE], axis=-1), k=2)[0]
    return 3.0 - (near[..., 1] - near[..., 0])  # walls where two centres are equally near


def fibres() -> np.ndarray:
    """A normal field drawn out along a direction that turns."""
    rng = np.random.default_rng(4)
    k = np.hypot(*np.meshgrid(np.fft.fftfreq(SIDE), 3.0 * np.fft.rfftfreq(SIDE), indexing="ij"))
    white = np.fft.rfft2(rng.standard_normal((SIDE, SIDE)))
    field = np.fft.irfft2(white * np.maximum(k, 1.0 / 48.0) ** -1.6, (SIDE, SIDE))
    y, x = np.mgrid[:SIDE, :SIDE]
    turn = 12.0 * np.sin(2.0 * np.pi * x / SIDE), 12.0 * np.sin(2.0 * np.pi * y / SIDE)
    return map_coordinates(field, (y + turn[0], x + turn[1]), mode="grid-wrap")


@pytest.mark.parametrize("clouds", [streets, open_cells, fibres])
def test_no_fractal_field_looks_like_streets_cells_or_fibres(clouds) -> None:
    assert says_so(grey(clouds()))


def test_plugins_have_notes_on_the_image(tmp_path, monkeypatch) -> None:
    def broken(path, variable):
        raise ValueError("no")

    def installed(group):
        assert group == "hcss_twin.image_notes"
        for name, load in (("good", lambda path, variable: (f"{path.name}, {variable}",)), ("bad", broken)):
            yield Origin(name, f"plugin-{name}", "1"), types.SimpleNamespace(load=lambda load=load: load)
        yield Origin("lost", "plugin-lost", "1"), importlib.metadata.PackageNotFoundError("gone")

    monkeypatch.setattr("hcss_twin.providers.registry.registry.installed", installed)
    np.save(tmp_path / "sky.npy", np.maximum(streets(), 0.0))
    choice = target_module.ImageChoice(pixel_size_m=1000.0)
    notes = read_target(tmp_path / "sky.npy", choice).notes
    assert "sky.npy, None" in notes
    assert any("plugin-bad 1 has no notes: ValueError: no" in note for note in notes)
    assert any("plugin-lost 1 has no notes" in note for note in notes)
