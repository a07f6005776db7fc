"""All wrong providers: mechanical changes of right ones, in a fixed order.

python campaigns/wrong_providers/wrong_providers.py       # prints name and sentence of each
"""

import wrong_atmosphere
import wrong_clouds
import wrong_elements
import wrong_maps
import wrong_radiance
import wrong_sensors
import wrong_shutters
import wrong_surfaces_and_particles
import wrong_variables


def wrong_providers():
    """Return all of them; names are unique."""
    return [
        *wrong_clouds.wrong_providers(),
        *wrong_surfaces_and_particles.sea(),
        *wrong_surfaces_and_particles.optics(),
        *wrong_atmosphere.wrong_providers(),
        *wrong_radiance.wrong_providers(),
        *wrong_sensors.wrong_providers(),
        *wrong_elements.wrong_providers(),
        *wrong_maps.wrong_providers(),
        *wrong_variables.wrong_providers(),
        *wrong_shutters.wrong_providers(),
    ]


if __name__ == "__main__":
    for each in wrong_providers():
        print(f"{each.name:60} {each.sentence}")
