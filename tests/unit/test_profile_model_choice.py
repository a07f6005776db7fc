"""Which model atmosphere belongs to a place and season."""

import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.atmosphere.cloud_top import SURFACE_TEMPERATURE_K, calendar_model, candidates, closest_model
from hcss_twin.models.atmosphere.profile_file import load_profile


def test_the_surface_temperatures_are_those_of_the_catalog():
    for name, temperature in SURFACE_TEMPERATURE_K.items():
        assert load_profile(name, Catalog()).temperature_K[0] == temperature


def test_every_model_is_chosen_somewhere():
    found = {closest_model(lat, kelvin) for lat in (0, 35, 60) for kelvin in range(240, 305)}
    assert found == set(SURFACE_TEMPERATURE_K)


@pytest.mark.parametrize("latitude", [-80, -50, -23.5, 0, 23.5, 40, 50, 90])
def test_north_and_south_have_the_same_candidates_and_opposite_seasons(latitude):
    assert candidates(latitude) == candidates(-latitude)
    swap = {"summer": "winter", "winter": "summer"}
    for month in range(1, 13):
        here, there = calendar_model(latitude, month), calendar_model(-latitude, (month + 5) % 12 + 1)
        assert here == there
        belt, _, season = here.rpartition("-")
        if season in swap and latitude:
            assert calendar_model(-latitude, month) == f"{belt}-{swap[season]}"
        assert here in candidates(latitude)
