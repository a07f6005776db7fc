"""Spectral radiance of a scene's columns, clear and cloudy, for users who need more than band radiances."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arguments import checked
from hcss_twin.core.arrays import Array
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine.provenance import Recorded
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.scenario.scenario import Scenario

_THICKNESSES = 5
"""Columns of each layer between its thinnest and its thickest cloud."""


@dataclass(frozen=True)
class ColumnSpectra:
    """Spectral radiance at the sensor of individual columns of a scene.

    Attributes
    ----------
    wavenumber_cm1 : ndarray (V,)
        Ascending.
    thickness_m : ndarray (N, L)
        Cloud thickness of each column in each layer; the first column is clear.
    radiance : ndarray (N, V)
        W m-2 sr-1 (cm-1)-1.
    bands : tuple of str (B,)
        Names of the bands.
    weights_cm1 : ndarray (B, V)
        Spectral response times step: ``radiance @ weights_cm1.T`` (N, B) are the band radiances in W m-2 sr-1.
    """

    wavenumber_cm1: Array
    thickness_m: Array
    radiance: Array
    bands: tuple[str, ...]
    weights_cm1: Array


@checked
def column_spectra(scene: Scenario | str | os.PathLike[str], time_s: float = 0.0) -> ColumnSpectra:
    """Return spectra of the clear column, and of five with cloud in each layer, thin to thick in equal ratios.

    All columns stand over the scenario's sea, also in a scene with other surfaces.

    Parameters
    ----------
    scene : Scenario or path-like
        A scenario, or a cube, whose own scenario is used.
    time_s : float
        After the scenario's start: decides where the sun is.

    Raises
    ------
    CubeError
        If the file is no finished cube or carries no scenario.
    HcssError
        If the scenario cannot be planned: a file or a provider is missing.
    """
    plan = make_plan(scene if isinstance(scene, Scenario) else _scenario_of(scene))
    grid = plan.spectral_grid
    thickness = np.concatenate((np.zeros((1, len(plan.layers))), _cloudy_columns(plan)))
    terms = plan.assembly.cloudy(grid.wavenumber_cm1, thickness, plan.sun_up_at(time_s))
    total: Array = np.sum(list(terms.values()), axis=0)
    return ColumnSpectra(
        grid.wavenumber_cm1, thickness, total, tuple(band.name for band in plan.bands), grid.weights_cm1
    )


def _scenario_of(cube: str | os.PathLike[str]) -> Scenario:
    with open_cube(cube) as dataset:
        recorded = Recorded.of(dict(dataset.attrs), os.fspath(cube))
    return Scenario.from_dict(recorded.scenario, base=recorded.base, origin=os.fspath(cube))


def _cloudy_columns(plan: Plan) -> Array:
    """Return columns (N, L) with cloud in one layer."""
    rows = []
    for index, (layer, cloudy) in enumerate(zip(plan.layers, plan.assembly.cloudy_layers, strict=True)):
        for thickness in np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES if cloudy else 0):
            row = np.zeros(len(plan.layers))
            row[index] = thickness
            rows.append(row)
    return np.array(rows).reshape(len(rows), len(plan.layers))
