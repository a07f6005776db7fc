"""Errors of assumed mean wavelengths compared with those of the scene's spectra."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from hcss_pyxel.mean_wavelength import MeanWavelength
from hcss_pyxel.radiometry import black_body_wavelength_um
from hcss_twin import open_cube


@dataclass(frozen=True)
class Compared:
    """One column of a scene in one band.

    Attributes
    ----------
    band : str
    radiance : float
        W m-2 sr-1.
    scene_um : float
        Mean wavelength by the scene's spectrum.
    central_error, black_body_error : float
        Relative error of the number of photons with ``central`` and ``black-body``.
    """

    band: str
    radiance: float
    scene_um: float
    central_error: float
    black_body_error: float


def compared(cube: str | os.PathLike[str], known: Iterable[MeanWavelength]) -> Iterator[Compared]:
    """Yield the columns of each band that the cube has.

    Raises
    ------
    CubeError
        If the cube cannot be read.
    """
    with open_cube(cube) as dataset:
        bands = [str(name) for name in dataset["band"].to_numpy()]
        central = dict(zip(bands, dataset["wavelength"].to_numpy().tolist(), strict=True))
        limits = dict(zip(bands, dataset["wavelength_bounds"].to_numpy().tolist(), strict=True))
    for mean_wavelength in known:
        if mean_wavelength.band not in central:
            continue
        black_body = black_body_wavelength_um(mean_wavelength.radiance, *limits[mean_wavelength.band])
        for radiance, scene, assumed in zip(
            mean_wavelength.radiance, mean_wavelength.wavelength_um, black_body, strict=True
        ):
            yield Compared(
                mean_wavelength.band,
                float(radiance),
                float(scene),
                central[mean_wavelength.band] / float(scene) - 1.0,
                float(assumed) / float(scene) - 1.0,
            )
