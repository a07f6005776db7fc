"""Blind test: brightness temperature of clear sea and opaque clouds where only place, time and view are given.

The clear scene takes profile, sea temperature and wind from the climatology of place and date. An opaque cloud has the
temperature that the reference channel measured, so that this channel tests the air above it alone and the others test
how the cloud differs between channels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hcss_evaluate.radiance.measured import Spot, read_spots
from hcss_twin import CatalogError, ImageError, Scenario, ScenarioError, simulate
from hcss_twin.core.reading import Reading
from hcss_twin.providers import Catalog, choose_from
from hcss_twin.scenario.bands import spectral_band

CHANNELS_UM = {
    "ir_039": (3.48, 4.36), "wv_062": (5.35, 7.15), "wv_073": (6.85, 7.85), "ir_087": (8.30, 9.10),
    "ir_097": (9.38, 9.94), "ir_108": (9.80, 11.80), "ir_120": (11.00, 13.00), "ir_134": (12.40, 14.40),
}  # fmt: skip
"""Nominal limits of SEVIRI's channels (D. M. A. Aminou, ESA Bulletin 111, 15, 2002), by usual names of variables."""

REFERENCE_UM = 10.8

_LAPSE_K_KM = 6.5
_OPAQUE = {"type": "deep-convection", "coverage": 1.0, "base": 500.0}


@dataclass(frozen=True)
class ChannelDifference:
    """Simulated less measured brightness temperature.

    Attributes
    ----------
    channel, kind : str
        Variable; "clear sea" or "opaque cloud".
    spots : int
    mean_K, sd_K : float
        Of the differences; the standard deviation is nan with one spot.
    measured_K : float
        Mean of the measured ones.
    """

    channel: str
    kind: str
    spots: int
    mean_K: float
    sd_K: float
    measured_K: float


@dataclass(frozen=True)
class BlindTest:
    """Result: differences by channel and kind, each spot with its simulated brightness temperatures, spots left out.

    Channels of ``responses`` were simulated with the response of a file; their limits are those of half power.
    """

    differences: tuple[ChannelDifference, ...]
    spots: tuple[Spot, ...]
    simulated_K: tuple[dict[str, float], ...]
    limits_um: dict[str, tuple[float, float]]
    notes: tuple[str, ...] = ()
    responses: dict[str, dict[str, str]] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return everything for JSON; nan is None."""
        differences = [asdict(difference) for difference in self.differences]
        for difference in differences:
            difference["sd_K"] = None if np.isnan(difference["sd_K"]) else difference["sd_K"]
        spots = [
            {**asdict(spot), "time": spot.time.isoformat(), "simulated_K": kelvin}
            for spot, kelvin in zip(self.spots, self.simulated_K, strict=True)
        ]
        return {
            "differences": differences,
            "spots": spots,
            "limits_um": self.limits_um,
            "responses": self.responses,
            "notes": list(self.notes),
        }


def blind_test(
    path: Path,
    limits_um: Mapping[str, tuple[float, float]],
    responses: Mapping[str, Mapping[str, str]] | None = None,
    *,
    most: int = 12,
    progress: Callable[[int, int], None] | None = None,
) -> BlindTest:
    """Simulate clear sea and opaque clouds at the places of a file, and compare.

    Parameters
    ----------
    path : Path
        See :func:`hcss_evaluate.radiance.measured.read_spots`.
    limits_um : mapping of str to (float, float)
        Limits of each channel, by variable.
    responses : mapping of str to mapping, optional
        Of channels with a measured response: the keys ``response`` and ``column`` of a band.
    most : int
        Largest number of spots of each kind, evenly spaced over the file.
    progress : callable, optional
        Called with the spots done and their number.

    Raises
    ------
    ImageError
        If no channel is near 10.8 um, or no image has clear sea or opaque cloud.
    """
    channels = list(limits_um)
    inside = [name for name, (low, high) in limits_um.items() if low <= REFERENCE_UM <= high]
    if not inside:
        raise ImageError(f"no channel contains {REFERENCE_UM} um, which spots are chosen in: {', '.join(channels)}")
    # Of several, the one whose middle is closest.
    reference = min(inside, key=lambda name: abs(sum(limits_um[name]) / 2.0 - REFERENCE_UM))
    spots = read_spots(path, channels, reference)
    kinds = list(dict.fromkeys(spot.kind for spot in spots))
    chosen = [spot for kind in kinds for spot in _spaced([spot for spot in spots if spot.kind == kind], most)]
    if not chosen:
        raise ImageError(f"{path}: no uniform pixels of clear sea or opaque cloud in which all channels have values")
    done, simulated, notes = [], [], []
    for number, spot in enumerate(chosen):
        if progress is not None:
            progress(number, len(chosen))
        try:
            simulated.append(simulated_kelvin(spot, limits_um, reference, responses or {}))
        except ScenarioError as error:  # ice, or no ships: the climatology lacks the place
            position = f"{spot.latitude:.1f} N, {spot.longitude:.1f} E"
            notes.append(f"left out, {spot.kind} at {position}: {' '.join(str(error).split())}")
        else:
            done.append(spot)
    if not done:
        raise ImageError(f"{path}: no spot can be simulated; {notes[0]}")
    differences = _differences(done, simulated, channels)
    of_files = {name: dict(response) for name, response in (responses or {}).items()}
    return BlindTest(differences, tuple(done), tuple(simulated), dict(limits_um), tuple(notes), of_files)


def known_channels(path: Path) -> dict[str, None]:
    """Return the variables of a file whose channels have known limits.

    Raises
    ------
    ImageError
        If there is none.
    """
    with Reading(path, CatalogError, "not a NetCDF file that can be read").netcdf() as file:
        found = [name for name in file.variables if name in CHANNELS_UM]
    if not found:
        raise ImageError(
            f"{path}: no variable named {', '.join(CHANNELS_UM)}; give --channel NAME=LOW-HIGH, um, or NAME=FILE"
        )
    return dict.fromkeys(found)


def channel_limits(name: str) -> tuple[float, float]:
    """Return the limits of a channel that has a known name.

    Raises
    ------
    ImageError
        If the name is not known.
    """
    if name not in CHANNELS_UM:
        raise ImageError(
            f"channel '{name}': not known, {choose_from(name, CHANNELS_UM)}, or {name}=LOW-HIGH in um, or {name}=FILE"
        )
    return CHANNELS_UM[name]


def half_power_limits(response: Mapping[str, str]) -> tuple[tuple[float, float], str]:
    """Return the outermost wavelengths with at least half of the largest response, um, and how its file was read.

    Parameters
    ----------
    response : mapping
        Keys ``response`` and ``column`` of a band.

    Raises
    ------
    ScenarioError, CatalogError
        If the file is missing or malformed.
    """
    scene = {"time": "2000-01-01T00:00:00Z", "place": {"latitude": 0.0, "longitude": 0.0}}
    (band,) = Scenario.from_dict({**scene, "bands": [{"name": "channel", **response}]}).bands
    measured = spectral_band(band, Catalog())
    inside = measured.wavelength_um[measured.response >= 0.5 * measured.response.max()]
    return (float(inside[0]), float(inside[-1])), measured.read_as


def _spaced(spots: list[Spot], most: int) -> list[Spot]:
    at = np.unique(np.linspace(0, len(spots) - 1, min(most, len(spots))).round().astype(int))
    return [spots[index] for index in at]


def simulated_kelvin(
    spot: Spot, limits_um: Mapping[str, tuple[float, float]], reference: str, responses: Mapping[str, Mapping[str, str]]
) -> dict[str, float]:
    """Return the simulated brightness temperature of a spot by channel, to compare with the measured one.

    Parameters
    ----------
    spot : Spot
        Place, time and view; of an opaque cloud also the temperature.
    limits_um : mapping of str to (float, float)
        Limits of each channel.
    reference : str
        Channel whose measured temperature an opaque cloud has.
    responses : mapping of str to mapping
        As for :func:`blind_test`.

    Raises
    ------
    ScenarioError
        If the climatology lacks the place.
    """
    bands = {f"channel-{number}": name for number, name in enumerate(limits_um)}
    scene: dict[str, Any] = {
        "title": "Blind test", "seed": 1, "time": spot.time.isoformat(),
        "place": {"latitude": spot.latitude, "longitude": spot.longitude},
        "view": {"zenith": spot.view_zenith, "azimuth": 0.0},
        "image": {"rows": 2, "columns": 2, "pixel_size": 3000.0},
        "frames": {"count": 1, "interval": 1.0},
        "motion": {"platform_speed": 0.0},
        "bands": [
            {"name": band, **responses.get(name, {"limits": list(limits_um[name])})} for band, name in bands.items()
        ],
        "output": {"variables": ["radiance", "brightness_temperature"]},
        "clouds": {"type": "stratus", "coverage": 0.0},
    }  # fmt: skip
    if spot.kind == "opaque cloud":
        kelvin = spot.kelvin[reference]
        top = float(np.clip(1e3 * (spot.clear_K - kelvin) / _LAPSE_K_KM, 3000.0, 16_000.0))
        scene["clouds"] = {**_OPAQUE, "top": top, "temperature": kelvin, "thickness_min": top - 600.0}
    cube = simulate(Scenario.from_dict(scene))
    values = cube["brightness_temperature"]
    return {name: float(values.sel(band=band).mean()) for band, name in bands.items()}


def _differences(
    spots: list[Spot], simulated: list[dict[str, float]], channels: list[str]
) -> tuple[ChannelDifference, ...]:
    found = []
    for kind in dict.fromkeys(spot.kind for spot in spots):
        pairs = [(spot, kelvin) for spot, kelvin in zip(spots, simulated, strict=True) if spot.kind == kind]
        for name in channels:
            difference = np.array([kelvin[name] - spot.kelvin[name] for spot, kelvin in pairs])
            sd = float(difference.std(ddof=1)) if len(pairs) > 1 else float("nan")
            measured = float(np.mean([spot.kelvin[name] for spot, _ in pairs]))
            found.append(ChannelDifference(name, kind, len(pairs), float(difference.mean()), sd, measured))
    return tuple(found)
