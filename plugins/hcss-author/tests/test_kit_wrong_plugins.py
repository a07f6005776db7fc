"""A sample of wrong packages: the law of the kit that refuses each, and what a run says before its first frame.

``wrong_plugins.py`` tries all of them.
"""

import pytest
from wrong_of_templates import WRONG
from wrong_plugins import refused_by_kit, refused_by_run

BY_NAME = {wrong.name: wrong for wrong in WRONG}

KIT = (
    ("SeaWrites", "arguments_are_left_as_they_were"),
    ("SeaBuffer", "no_later_call_changes_a_result"),
    ("SeaKept", "results_belong_to_the_caller"),
    ("SeaSeeds", "global_random_numbers_are_left_alone"),
    ("SeaPrints", "nothing_is_printed"),
    ("SeaSingle", "results_are_in_double_precision"),
    ("SeaGrazing", "grazing_light_is_emitted_and_reflected"),
    ("GasNoMoreAirBeyond60", "grazing_paths_transmit_less"),
    ("ModelVertical", "slanted_cloud_absorbs_by_its_slant_path"),
    ("ModelCloudTopsAre20K", "opaque_cloud_has_the_temperature_of_its_top"),
    ("OpticsFirst", "results_do_not_depend_on_earlier_calls"),
    ("CloudsFromWindow", "windows_equal_the_whole"),
    ("CloudsBuffer", "no_later_call_changes_a_result"),
    ("CloudsTheSeedIsIgnored", "seed_matters"),
    ("CloudsOfOneTime", "declared_time_matters"),
    ("CloudsWindHasTheWrongSign", "frozen_field_only_translates"),
    ("ElementOfWindow", "a_window_has_the_pixels_of_the_image"),
    ("ElementGlobal", "global_random_numbers_are_left_alone"),
    ("SurfaceOfWindow", "a_window_has_the_points_of_the_image"),
    ("VariableAnInputIsReturned", "no_later_call_changes_a_result"),
    ("VariableInPlace", "arguments_are_left_as_they_were"),
    ("SensorNoiseWithoutASeed", "same_seed_same_bits"),
    ("SensorNoiseIgnoresThePlaceIn", "seed_and_place_matter_to_noise"),
    ("SensorRadianceHasTheWrongSign", "brighter_is_measured_as_brighter"),
    ("SensorReturns", "no_later_call_changes_a_result"),
    ("SensorContrastOfTheFrame", "a_window_is_measured_as_the_image"),
)
"""Names of wrong packages, and a law that refuses each."""

RUN = (
    ("SeaGlobalNoise", "breaks the law 'results do not depend on earlier calls'"),
    ("GasBuffer", "breaks the law 'no later call changes a result'"),
    ("CloudsFromWindow", "breaks the law 'windows equal the whole'"),
    ("CloudsTheSeedIsIgnored", "breaks the law 'seed matters'"),
    ("ElementOfWindow", "breaks the law 'a window has the pixels of the image'"),
    ("SurfaceGrows", "breaks the law"),
    ("SensorNoiseOfOneSeed", "breaks the law 'seed and place matter to noise'"),
    ("SensorRadianceInMw", "breaks the law 'brighter is measured as brighter'"),
    ("ElementTemperatureInDegreesCelsius", "breaks the law 'a body shines by its temperature'"),
    ("SensorBuffer", "breaks the law 'no later call changes a result'"),
    ("SensorSecond", "measure() raised IndexError: list index out of range, at "),
    ("OpticsMisspelt", "AttributeError"),
)
"""Names of wrong packages, and what a run says of each."""


@pytest.fixture(scope="module")
def refused():
    """Every law that refuses each package; the kit starts once."""
    cases = [(BY_NAME[name].kind, BY_NAME[name].cls) for name, _ in KIT]
    return dict(zip((name for name, _ in KIT), refused_by_kit(cases, most=0), strict=True))


@pytest.mark.parametrize(("name", "law"), KIT)
def test_the_law_refuses_the_wrong_package(refused, name, law):
    assert law in refused[name]


@pytest.mark.parametrize(("name", "said"), RUN)
def test_a_run_refuses_the_wrong_package_by_name(name, said):
    error = refused_by_run(BY_NAME[name].kind, BY_NAME[name].cls)
    assert "'mine' of hcss-mine 1.0" in error
    assert said in error


def test_there_are_mistakes_of_every_kind_and_each_has_a_name():
    assert len(BY_NAME) == len(WRONG) > 60
    assert len({wrong.kind for wrong in WRONG}) == 9
