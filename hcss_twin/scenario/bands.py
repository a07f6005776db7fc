"""Bands: named in the catalog, given by limits, or by a measured spectral response."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError, choose_from
from hcss_twin.radiance.spectral_band import SpectralBand
from hcss_twin.scenario.band_entries import (
    NARROWEST,
    AnyBand,
    GaussianBand,
    LimitsBand,
    ResponseBand,
    band_name,
)
from hcss_twin.scenario.wording import shown

Array = NDArray[np.float64]

_WAVELENGTH = re.compile(r"([a-z]+)-?([0-9]+(?:\.[0-9]+)?)(?: ?um)?")


def named_bands(catalog: Catalog) -> Mapping[str, Mapping[str, Any]]:
    """Bands of the catalog by name."""
    bands: Mapping[str, Mapping[str, Any]] = catalog.toml(catalog.find("bands", "", ".toml"))["bands"]
    return bands


GAUSSIAN_NODES = 129
"""Wavelengths at which a Gaussian response is known; linear between them it is off by at most 6e-4 of the peak."""


def unknown_band(name: str, known: Mapping[str, Mapping[str, Any]]) -> str:
    """Say that there is no band of a name, which there are, and which is closest.

    A name that ends in a number is taken for a wavelength in um: closest is the narrowest band around it whose name
    begins alike, or else the one whose middle is nearest.
    """
    told = f"no band named {shown(name)}; {choose_from(name, known)}"
    match = _WAVELENGTH.fullmatch(name)
    alike = [each for each in known if match and each.startswith(f"{match[1]}-")]
    if not match or not alike:
        return told
    wavelength = float(match[2])
    limits = {each: known[each]["limits_um"] for each in alike}
    around = [each for each in alike if limits[each][0] <= wavelength <= limits[each][1]]
    guess = (
        min(around, key=lambda each: limits[each][1] - limits[each][0])
        if around
        else min(alike, key=lambda each: abs(sum(limits[each]) / 2 - wavelength))
    )
    low, high = limits[guess]
    return f"{told.partition('; closest is')[0]}; closest is '{guess}' ({low:g} to {high:g} um)"


def spectral_band(band: AnyBand, catalog: Catalog) -> SpectralBand:
    """Resolve one entry of a scenario's ``bands``.

    Raises
    ------
    CatalogError
        If a name is unknown or a response file is malformed.
    """
    if isinstance(band, ResponseBand):
        wavelength, response = read_response(band.response, catalog)
        return SpectralBand(band.name, wavelength, response)
    if isinstance(band, GaussianBand):
        wavelength = np.linspace(*band.ends_um, GAUSSIAN_NODES)
        distance = (wavelength - band.center_um) / band.fwhm_um
        return SpectralBand(band.name, wavelength, np.exp(-4.0 * np.log(2.0) * distance**2))
    if isinstance(band, str):
        known = named_bands(catalog)
        if band not in known:
            raise CatalogError(unknown_band(band, known))
        limits = known[band]["limits_um"]
    elif isinstance(band, LimitsBand):
        limits = band.limits
    else:
        limits = band
    return SpectralBand(band_name(band), np.array(limits, dtype=np.float64), np.ones(2))


def read_response(file: str, catalog: Catalog) -> tuple[Array, Array]:
    """Read a measured spectral response.

    Returns
    -------
    wavelength_um, response : ndarray (N,)

    Raises
    ------
    CatalogError
        If the file is missing or malformed.
    """
    path = catalog.file(file)
    columns = catalog.columns(path)
    for required in ("wavelength_um", "response"):
        if required not in columns:
            raise CatalogError(f"{path}: column '{required}' is missing; found {', '.join(columns)}")
    wavelength, response = columns["wavelength_um"], columns["response"]
    if wavelength.size < 2 or np.any(np.diff(wavelength) <= 0) or wavelength[0] <= 0:
        raise CatalogError(f"{path}: wavelength_um must be positive and ascend over at least two rows")
    if wavelength[-1] - wavelength[0] < NARROWEST * wavelength[-1]:
        raise CatalogError(f"{path}: too narrow; allowed: at least {NARROWEST:g} of the wavelength")
    if np.any(response < 0) or np.any(response > 1) or not np.any(response > 0):
        raise CatalogError(f"{path}: response must lie in 0..1 and be positive somewhere")
    return wavelength, response
