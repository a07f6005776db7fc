"""Profiles by catalog name or from a user's file."""

from __future__ import annotations

from hcss_twin.atmosphere.profile_building import build_profile
from hcss_twin.atmosphere.sounding import read_sounding
from hcss_twin.catalog import Catalog
from hcss_twin.errors import CatalogError
from hcss_twin.physics.profile import Profile

STANDARD = "us-standard-1976"
"""Model that completes profiles where nothing else is asked for."""


def load_profile(name: str, catalog: Catalog, above: str = STANDARD) -> Profile:
    """Read a profile by catalog name or from a user's CSV or NetCDF file (docs/atmosphere-profiles.md).

    Parameters
    ----------
    name : str
        Catalog name or path.
    catalog : Catalog
    above : str
        Profile, by name or path, that gives the gases a file leaves out and the air above its last level;
        it must reach 100 km.

    Raises
    ------
    CatalogError
        If a file is missing or malformed, or its levels are not physical; with the line or level.
    """

    def model() -> Profile:
        def incomplete() -> Profile:
            raise CatalogError(
                f"'{above}' cannot complete '{name}': it has gaps itself; allowed: whole profiles"
            )

        return build_profile(read_sounding(catalog.find(above, "atmospheres", ".csv"), above), incomplete)

    return build_profile(read_sounding(catalog.find(name, "atmospheres", ".csv"), name), model)
