"""Mean photon wavelengths of a scene in its bands, which convert band radiance to photons.

Photons of a band are the integral of ``lambda L / (h c)``; with the mean wavelength ``integral(lambda L) /
integral(L)`` they are ``mean L_band / (h c)`` exactly.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hcss_twin.core.arrays import Array
from hcss_twin.cube.reader import open_cube
from hcss_twin.engine.provenance import Recorded
from hcss_twin.physics.planck import wavenumber_from_um
from hcss_twin.plan.make_plan import make_plan
from hcss_twin.plan.plan import Plan
from hcss_twin.scenario.scenario import Scenario

_THICKNESSES = 5
"""Columns of each layer between its thinnest and its thickest cloud."""


@dataclass(frozen=True)
class MeanWavelength:
    """Mean wavelength of individual columns of a scene in one band: clear sky first, then cloud.

    Attributes
    ----------
    band : str
    radiance : ndarray (N,)
        W m-2 sr-1.
    wavelength_um : ndarray (N,)
    """

    band: str
    radiance: Array
    wavelength_um: Array

    def of_image(self, radiance: Array) -> float:
        """Return the mean wavelength of a whole image, which gives the correct total number of photons.

        Parameters
        ----------
        radiance : ndarray
            Pixels of the band. Each has the wavelength of columns of the same radiance, in straight lines between
            them and that of the darkest and the brightest beyond them.
        """
        order = np.argsort(self.radiance)
        each = np.interp(radiance, self.radiance[order], self.wavelength_um[order])
        total = float(np.sum(radiance, dtype=np.float64))
        return float(np.sum(each * radiance)) / total if total > 0.0 else float(np.mean(each))


def mean_wavelengths(plan: Plan, time_s: float = 0.0) -> tuple[MeanWavelength, ...]:
    """Return mean wavelengths of clear and cloudy columns in each band, at every wavenumber of the dense grid.

    Parameters
    ----------
    time_s : float
        After the scenario's start: decides where the sun is.

    Raises
    ------
    ProviderError
        If a provider breaks its contract.
    """
    grid, sun = plan.spectral_grid, plan.sun_up_at(time_s)
    wavenumber = grid.wavenumber_cm1
    spectra = [_total(plan.assembly.model.clear(wavenumber, sun))[None, :]]
    columns = _columns(plan)
    if columns.size:
        spectra.append(_total(plan.assembly.model.cloudy(wavenumber, columns, sun)))
    stacked = np.concatenate(spectra)
    wavelength_um = wavenumber_from_um(wavenumber)
    energy = stacked @ grid.weights_cm1.T
    weighted = (stacked * wavelength_um) @ grid.weights_cm1.T
    central = np.array([band.central_um for band in plan.bands])
    mean = np.divide(weighted, energy, out=np.broadcast_to(central, energy.shape).copy(), where=energy > 0.0)
    return tuple(MeanWavelength(band.name, energy[:, index], mean[:, index]) for index, band in enumerate(plan.bands))


def mean_wavelengths_of(cube: str | os.PathLike[str]) -> tuple[MeanWavelength, ...]:
    """Return mean wavelengths of the scene of a cube, at the scenario's start.

    Raises
    ------
    CubeError
        If the file is no finished cube or carries no scenario.
    HcssError
        If the scenario cannot be planned here: a file or a provider is missing.
    """
    with open_cube(cube) as dataset:
        recorded = Recorded.of(dict(dataset.attrs), os.fspath(cube))
    scenario = Scenario.from_dict(recorded.scenario, base=recorded.base, origin=os.fspath(cube))
    return mean_wavelengths(make_plan(scenario))


def _total(terms: Mapping[str, Array]) -> Array:
    total: Array = np.sum([np.asarray(term, dtype=np.float64) for term in terms.values()], axis=0)
    return total


def _columns(plan: Plan) -> Array:
    """Return columns (N, L) with cloud in one layer, thickness increasing in equal ratios."""
    rows = []
    for index, (layer, cloudy) in enumerate(zip(plan.layers, plan.assembly.cloudy_layers, strict=True)):
        if not cloudy:
            continue
        for thickness in np.geomspace(layer.thickness_min_m, layer.thickness_max_m, _THICKNESSES):
            row = np.zeros(len(plan.layers))
            row[index] = thickness
            rows.append(row)
    return np.array(rows).reshape(len(rows), len(plan.layers))
