"""The page of a cube."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hcss_twin.cube.reader import open_cube
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.report.cube_report import provenance, quality, scene
from hcss_twin.report.cube_report.choice import read_all
from hcss_twin.report.cube_report.content import WINDOW_PIXELS, Reader, quantities
from hcss_twin.report.cube_report.curves import curves, numbers_table
from hcss_twin.report.cube_report.viewer import viewer, viewer_script, viewer_style
from hcss_twin.report.page.page import Page, Section, note

if TYPE_CHECKING:
    import xarray as xr


def cube_page(path: Path) -> Page:
    """Return the page of a cube, clean or measured, NetCDF or Zarr.

    Raises
    ------
    CubeError
        If it is no finished cube.
    """
    with open_cube(path) as dataset:
        sections, scripts = _frames(dataset)
        if SENSOR_ATTRIBUTE in dataset.attrs:
            sections.append(Section("Sensor", list(provenance.sensor(dataset))))
        sections += [
            Section("Scene", list(scene.scene_blocks(dataset))),
            Section("Certificate", list(quality.certificate(dataset))),
            Section("Plan and what it left out", [*quality.ledger(dataset), *quality.budget(dataset)]),
            Section("Provenance", list(provenance.provenance(dataset, path))),
        ]
        title = str(dataset.attrs.get("title", path.name))
        return Page(title, _subtitle(dataset, path), sections, scripts, [viewer_style()])


def _frames(dataset: xr.Dataset) -> tuple[list[Section], list[str]]:
    shown = quantities(dataset)
    if not shown or not all(dataset.sizes.values()):
        return [Section("Frames", [note("The cube holds no variable with frames.")])], []
    reader = Reader.of(dataset)
    series, first, others = read_all(reader, shown)
    rows, columns = (min(WINDOW_PIXELS, dataset.sizes[dim]) for dim in ("y", "x"))
    return [
        Section("Frames", [viewer(reader, series, first, others)]),
        Section("Numbers and curves", [curves(dataset, series, (rows, columns)), numbers_table(series)]),
    ], [viewer_script(dataset, series)]


def _subtitle(dataset: xr.Dataset, path: Path) -> str:
    sizes = dataset.sizes
    words = ["Measured cube" if SENSOR_ATTRIBUTE in dataset.attrs else "Cube", f"{path.name}:"]
    told = []
    if "time" in sizes:
        told.append("one frame" if sizes["time"] == 1 else f"{sizes['time']} frames")
    if {"y", "x"} <= set(sizes):
        told.append(f"{sizes['y']} x {sizes['x']} pixels")
    if "band" in sizes:
        told.append("bands " + ", ".join(str(each) for each in dataset["band"].to_numpy()))
    if "time" in dataset.coords:
        told.append(f"from {np.datetime_as_string(dataset['time'].to_numpy()[0], unit='s')}Z")
    return " ".join([*words, ", ".join(told)])
