"""Plans with clouds that a test draws itself, and a sun where it is wanted."""

from dataclasses import dataclass, replace

import numpy as np

from hcss_twin.cube.requested_variables import expand
from hcss_twin.plan.displaced_clouds import DisplacedClouds
from hcss_twin.plan.slant_paths import slant_paths
from hcss_twin.providers import CloudDeclaration, Sun
from hcss_twin.scenario.models import Slant


@dataclass
class FixedSun:
    sun: Sun

    def at(self, time_s):
        return self.sun

    def positions(self, time_s):
        return tuple(np.full(time_s.size, x) for x in (self.sun.zenith_deg, self.sun.azimuth_deg, self.sun.distance_au))


@dataclass
class HandMade:
    """A plane of cloud given by a function of the image's rows and columns, in any range."""

    thickness: object
    margin: tuple
    declares = CloudDeclaration()

    def thickness_m(self, time_s, rows, columns):
        y, x = np.mgrid[rows, columns]
        return self.thickness(y - self.margin[0], x - self.margin[1]).astype(np.float32)


def paths_of(shadows, parallax, view, sun_zenith_deg, sun_azimuth_deg):
    """Slant paths with shadows and parallax on or off."""
    names = {True: "on", False: "off"}
    return slant_paths(Slant(shadows=names[shadows], parallax=names[parallax]), view, sun_zenith_deg, sun_azimuth_deg)


def with_clouds(plan, shapes, slant, sun, **more):
    """The plan with clouds that functions give, under another sun."""
    point_m = plan.grid.pixel_size_m / plan.samples_per_pixel
    generators = []
    for layer, shape in zip(plan.layers, shapes, strict=True):
        margin = slant.margin(layer, point_m)
        generators.append(DisplacedClouds(HandMade(shape, margin), margin, slant.of_view(layer, point_m)))
    variables = tuple(expand(["all"], plan.assembly.model.terms, len(plan.layers), **more))
    return replace(
        plan,
        assembly=replace(plan.assembly, slant=slant, generators=tuple(generators)),
        sun_track=FixedSun(sun),
        sun_zenith_deg=np.array([sun.zenith_deg]),
        sun_azimuth_deg=np.array([sun.azimuth_deg]),
        variables=variables,
        computed=variables,
    )
