"""Part of a layer has the densities and the cells of the whole, so that amounts do not jump with the ends of a leg."""

import dataclasses

import numpy as np
import pytest

from hcss_twin.core.catalog import Catalog, catalog_root
from hcss_twin.models.atmosphere.band_model.absorber_density import COLD_SELF_COLUMN, LevelState, level_state
from hcss_twin.models.atmosphere.band_model.absorption import read_coefficients
from hcss_twin.models.atmosphere.band_model.layers import LayeredAir
from hcss_twin.models.atmosphere.band_model.provider import BandModelTransmittance
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.parameters import BandModelParameters
from hcss_twin.physics.paths import SPACE, Leg, Path, to_space
from hcss_twin.physics.profile import EARTH_RADIUS_M
from hcss_twin.providers import AtmosphereInputs

CATALOG = Catalog()
COEFFICIENTS = read_coefficients(catalog_root() / "atmospheres" / "lowtran7-band-model.nc")
BOUNDARY_HAZE, TROPOSPHERIC_HAZE = -5, -4
"""Columns of the aerosol up to 2 km, which fades out by 3 km, and of that above, which fades in there."""

ENDS_M = (500.0, 1000.0, 1250.0, 1500.0, 2000.0, 2500.0, 3000.0, 10e3, 10.5e3, 13e3, 26.25e3, 30e3)
"""Levels, borders of cells, and altitudes from which the rest of a layer is thicker than a cell."""


def layered(profile="us-standard-1976", **parameters):
    state = level_state(load_profile(profile, CATALOG), COEFFICIENTS, BandModelParameters(**parameters))
    return LayeredAir(state, EARTH_RADIUS_M)


def amounts(air, *legs):
    return air.amounts([Path((leg,)) for leg in legs])


@pytest.mark.parametrize("zenith", [0.0, 60.0, 85.0, 88.0])
@pytest.mark.parametrize("profile", ["us-standard-1976", "tropical", "subarctic-winter"])
def test_amounts_do_not_jump_with_the_ends_of_a_leg(profile, zenith):
    air = layered(profile, visibility_km=5.0)
    (whole,) = np.abs(amounts(air, Leg(0.0, SPACE, zenith)))
    for end in ENDS_M:
        below, above = (
            amounts(
                air,
                Leg(height, SPACE, zenith),
                Leg(0.0, height, zenith),
                Leg(777.0, height, zenith) if height > 777.0 else Leg(height, 777.0, zenith),
                Leg(height, 2950.0, zenith) if height < 2700.0 else Leg(2300.0, height, zenith),
            )
            for height in (end - 1e-3, end + 1e-3)
        )
        # What lies in 2 mm is at most some 1e-5 of the haze at 88 degrees.
        assert np.max(np.abs(above - below) / whole) < 1.5e-5, end


@pytest.mark.parametrize("cut", [430.0, 1000.0, 1700.0, 2200.0, 2999.0, 12.8e3])
@pytest.mark.parametrize("profile", ["us-standard-1976", "subarctic-winter"])
def test_pieces_of_a_vertical_path_have_the_amounts_of_the_whole(profile, cut):
    whole, lower, upper = amounts(layered(profile), Leg(0.0, SPACE, 0.0), Leg(0.0, cut, 0.0), Leg(cut, SPACE, 0.0))
    # The self-continuum of water depends on the mean temperature of each piece.
    both, whole = np.delete(lower + upper, COLD_SELF_COLUMN), np.delete(whole, COLD_SELF_COLUMN)
    np.testing.assert_allclose(both, whole, rtol=1e-11)


@pytest.mark.parametrize(("low", "high"), [(2000.0, 2700.0), (2300.0, 2700.0), (2300.0, 3000.0), (2999.0, 3000.0)])
def test_haze_fades_linearly_in_parts_of_the_layer_above_2_km_too(low, high):
    air = layered(visibility_km=8.0)
    (whole, part) = amounts(air, Leg(2000.0, 3000.0, 0.0), Leg(low, high, 0.0))
    begin, end = low / 1000.0 - 2.0, high / 1000.0 - 2.0
    rising = end**2 - begin**2  # of the integral of s from 0 to 1
    assert part[TROPOSPHERIC_HAZE] == pytest.approx(rising * whole[TROPOSPHERIC_HAZE], rel=1e-9)
    falling = (1.0 - begin) ** 2 - (1.0 - end) ** 2
    assert part[BOUNDARY_HAZE] == pytest.approx(falling * whole[BOUNDARY_HAZE], rel=1e-9)


@pytest.mark.parametrize("distance", [1e-12, 1e-9, 1e-7])
def test_pieces_as_thin_as_rounding_are_no_pieces(distance):
    """Heights of cloud tops are sums: they may miss a level, or the border of cells, by rounding."""
    air = layered()
    for level in (500.0, 2000.0, 2500.0, 13e3):
        exact, *near = amounts(
            air, *(Leg(height, SPACE, 85.0) for height in (level, level - distance, level + distance))
        )
        np.testing.assert_allclose(near, [exact, exact], rtol=1e-9)
        thin = amounts(air, Leg(level - distance, level, 85.0), Leg(level, level + distance, 85.0))
        np.testing.assert_array_equal(thin, 0.0)


def test_levels_a_hair_apart_are_as_one():
    state = level_state(load_profile("us-standard-1976", CATALOG), COEFFICIENTS, BandModelParameters())
    twice = np.sort(np.append(np.arange(state.altitude_m.size), 3))
    doubled = LevelState(*(getattr(state, field.name)[twice] for field in dataclasses.fields(state)))
    doubled.altitude_m[4] += 1e-7
    legs = [Leg(height, SPACE, 80.0) for height in (0.0, 2500.0, 3000.0, 3200.0)]
    expected = amounts(LayeredAir(state, EARTH_RADIUS_M), *legs)
    np.testing.assert_allclose(amounts(LayeredAir(doubled, EARTH_RADIUS_M), *legs), expected, rtol=1e-6)


@pytest.mark.parametrize("zenith", [0.0, 85.0])
def test_emission_seen_from_space_does_not_jump_with_the_height_it_begins_at(zenith):
    gas = BandModelTransmittance(
        AtmosphereInputs(load_profile("us-standard-1976", CATALOG), CATALOG),
        BandModelParameters(aerosol="urban", visibility_km=17.0),
    )
    wavenumber = np.arange(700.0, 3000.0, 50.0)
    for end in ENDS_M[:-1]:
        below, above = gas.path_radiance(wavenumber, [to_space(height, zenith) for height in (end - 1e-4, end + 1e-4)])
        np.testing.assert_allclose(above, below, rtol=3e-7)


def test_the_whole_profile_consists_of_whole_layers():
    """With nothing cut off, cells are equal shares of their layers."""
    state = level_state(load_profile("tropical", CATALOG), COEFFICIENTS, BandModelParameters())
    layers = LayeredAir(state, EARTH_RADIUS_M).between(0.0, SPACE)
    counts = np.diff(np.append(layers.first_cell, layers.thickness_m.size))
    thickness = np.diff(state.altitude_m)
    # 1 km is two cells below 12 km and one above, 5 km are two.
    low, thick = state.altitude_m[:-1] < 12e3, thickness > 2500.0
    np.testing.assert_array_equal(counts, np.where(low | thick, 2, 1))
    np.testing.assert_allclose(layers.thickness_m, np.repeat(thickness / counts, counts))
