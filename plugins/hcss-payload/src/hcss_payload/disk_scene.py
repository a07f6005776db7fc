"""Whether a scene is a full disk whose places have suns, air and sea of their own."""

from __future__ import annotations

import numpy as np

from hcss_payload.climate import ZonalClimate
from hcss_payload.directions import Hemisphere, PassDirections
from hcss_payload.disk import Disk, disk_around, sun_at, with_glint
from hcss_payload.earth import SEMI_MAJOR_AXIS_M
from hcss_payload.sampled_pass import SampledPass
from hcss_payload.scene_plane import FARTHEST_DEG, surface_place
from hcss_payload.trajectory import Trajectory
from hcss_payload.zonal_disk import ZonalDisk, zonal_disk
from hcss_twin import Scenario
from hcss_twin.physics.geodesy import Ellipsoid
from hcss_twin.plan.combinations import Excluded
from hcss_twin.providers import Array, Catalog, Problem, ScenarioError
from hcss_twin.scenario.bands import spectral_band

SUNS = 3
"""Times of the frames at which suns are compared."""

SUNLIT_UM = 6.0
"""Wavelength below which the mirror image of the sun is brighter than a hundredth of the sea."""

_STILL_M = 1.0
"""Largest motion of a camera that stands still above the Earth."""


def excluded_beside_climate(scenario: Scenario) -> tuple[Excluded, ...]:
    """Return what cannot be computed with air and sea by latitude."""
    air, sea, without = scenario.atmosphere, scenario.sea, "to leave it out"
    texture, vapour = ((each or 0.0) > 0.0 for each in (sea.temperature_texture, air.water_vapour_texture))
    return (
        Excluded("atmosphere.profile", air.profile is not None, "another profile", without),
        Excluded("atmosphere.inversion", air.inversion is not None, "an inversion", without),
        Excluded("atmosphere.water_vapour_texture", vapour, "texture of vapour", "0"),
        Excluded("sea.temperature", sea.temperature is not None, "another temperature", without),
        Excluded("sea.temperature_texture", texture, "texture of the sea", "0"),
        Excluded("surfaces", scenario.surfaces is not None, "a map of the ground", "sea everywhere"),
        Excluded("elements", bool(scenario.elements), "elements", "no elements"),
    )


def climate_of(scenario: Scenario, catalog: Catalog, choice: str) -> ZonalClimate | None:
    """Return the air and sea by latitude if ``camera.climate`` asks for them.

    Raises
    ------
    ScenarioError
        If the scenario has what they contradict; names the field.
    """
    if choice == "place":
        return None
    effect = "camera.climate = 'latitude', which has its own air and sea"
    Excluded.require_none(effect, excluded_beside_climate(scenario), "camera.climate = 'place'")
    return ZonalClimate(catalog, scenario.time, (scenario.place.latitude, scenario.place.longitude))


def whole_disk(
    scenario: Scenario,
    catalog: Catalog,
    trajectory: Trajectory,
    views: PassDirections,
    seen: SampledPass,
    times_s: Array,
    climate: bool,
) -> Disk | ZonalDisk | None:
    """Return the directions of a disk whose places differ; None if all pixels have the sun and air of [place].

    Places differ where directions fill the hemisphere, the camera stands still above the Earth, and sunlight or
    ``climate`` does differ. By night all places have the same sun: none.

    Raises
    ------
    ScenarioError
        If places cannot differ, but ``camera.climate`` asks for it, or a moving camera sees a sunlit disk; names the
        field.
    """
    positions = np.array([trajectory.at(time_s) for time_s in (times_s[0], times_s[times_s.size // 2], times_s[-1])])
    camera = positions[0]
    still = bool(np.all(np.linalg.norm(positions - camera, axis=1) < _STILL_M))
    if not (still and isinstance(views, Hemisphere)):
        if climate:
            message = "'latitude' without a full disk from a camera that stands still above the Earth; allowed: 'place'"
            raise ScenarioError([Problem("camera.climate", message)])
        if not still and isinstance(views, Hemisphere) and seen.limit_deg is not None:
            _require_night(scenario, seen, times_s)
        return None
    instants = np.unique(times_s[[0, times_s.size // 2, -1]])
    below = tuple(float(degrees) for degrees in surface_place(camera))
    times = tuple(instants.tolist())
    disk = disk_around(seen.toward, seen.limit_deg, (below[0], below[1]), camera, scenario.time, times)
    edge = np.linspace(-1.0, 1.0, 9).tolist()
    lit = any(sun is not None for view in disk.at([(x, y) for x in edge for y in edge]) for sun in disk.suns(view))
    if not (lit or climate):
        return None
    centre_m = Ellipsoid.to_earth_centred(np.array(scenario.place.latitude), np.array(scenario.place.longitude))
    under = camera / np.linalg.norm(camera)
    apart = np.degrees(np.arccos(np.clip(centre_m @ under / np.linalg.norm(centre_m), -1.0, 1.0)))
    zenith = np.arccos(seen.toward[:, 2].min()) if seen.limit_deg is None else np.radians(seen.limit_deg)
    reach = np.degrees(zenith - np.arcsin(SEMI_MAJOR_AXIS_M / np.linalg.norm(camera) * np.sin(zenith)))
    if apart + reach > FARTHEST_DEG:
        message = (
            f"{apart:.3g} deg from the place below the camera, and clouds end {FARTHEST_DEG:g} deg from [place]: a "
            f"disk of {reach:.3g} deg does not fit; allowed: within {FARTHEST_DEG - reach:.2g} deg of "
            f"{below[0]:.2f} N {below[1]:.2f} E"
        )
        raise ScenarioError([Problem("place", message)])
    if not lit and scenario.sea.wind_from % 90.0 == 0.0:  # the east of the disk is the mirror image of its west
        return zonal_disk(disk, seen.toward, seen.place_deg[:, 0], seen.limit_deg)
    bands = [spectral_band(band, catalog) for band in scenario.bands]
    return with_glint(disk) if lit and any(band.lower_um < SUNLIT_UM for band in bands) else disk


def _require_night(scenario: Scenario, seen: SampledPass, times_s: Array) -> None:
    """Raise a :class:`ScenarioError` if a moving camera sees a disk up to the limb where the sun is up."""
    # Directions of a moving camera do not tell places, so that tables toward them have one sun; over a disk it differs
    # by as much as the horizon is wide.
    instants = times_s[[0, times_s.size // 2, -1]].tolist()
    step = max(1, len(seen.place_deg) // 64)
    places = seen.place_deg[::step].tolist()
    if any(sun_at(scenario.time, north, east, time_s).is_up for north, east in places for time_s in instants):
        message = (
            "moves, and the camera sees the Earth up to the limb by day, where each pixel would need its own sun; "
            "allowed: a camera that stands still above the Earth (geostationary), night, or a field without the limb"
        )
        raise ScenarioError([Problem("orbit", message)])


def disk_notes(climate: bool) -> tuple[str, ...]:
    """Return what the plan says about the places of a disk."""
    air = "air and sea by latitude (sea everywhere)" if climate else "the air and sea of [place]"
    return (
        f"camera: each pixel has its own view and sun, and {air}; winds are bearings at each pixel; elements have the "
        "air and sun of [place]",
    )
