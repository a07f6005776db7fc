"""A fixed sample of wrong providers, each refused by the law that is meant for it."""

import pytest
from kit_run import laws_broken
from right_providers import right_providers
from wrong_providers import wrong_providers

RIGHT = {each.name: each for each in right_providers()}
WRONG = {each.name: each for each in wrong_providers()}

SAMPLE = (
    ("fractal-sky.inputs.seed-dropped", "seed_matters"),
    ("fractal-sky.thickness_m.time_s.dropped", "declared_time_matters"),
    ("fractal-sky.inputs.minimum-double", "thickness_keeps_other_limits"),
    ("cox-munk-10.brdf.half", "albedo_and_emissivity_sum_to_one"),
    ("cox-munk-10.emissivity.mu.complement", "sea_emits_most_upward"),
    ("cox-munk-10.brdf.relative_azimuth.turned", "sunlight_is_reflected_to_the_side_of_the_glint"),
    ("rough-sea.reflection_weights.nodes-reversed", "weights_see_the_sky_that_the_brdf_sees"),
    ("rough-sea.mean_square_slope.percent", "waves_are_of_a_sea"),
    ("cox-munk-10.emissivity.wavenumber.double", "declared_range_is_usable_to_its_ends"),
    ("mie.extinction_m1.per-km", "extinction_is_that_of_particles_of_this_size"),
    ("mie.moments.alternating", "large_particles_scatter_forward"),
    ("glowing-gas.path_radiance.per-um", "path_radiance_is_that_of_air_at_its_temperatures"),
    ("glowing-gas.path_radiance.paths.km", "low_air_shines_with_the_temperature_of_low_air"),
    ("band-model-none.absorber_amounts.paths.each-leg-once", "amounts_of_a_leg_crossed_twice_are_double"),
    ("glowing-gas.solar_path_radiance.percent", "no_more_sunlight_is_scattered_than_is_lost"),
    ("band-model-none.transmittance.half", "leg_without_length_transmits_everything"),
    ("malkmus-5.legs-multiplied", "dividing_a_leg_changes_nothing"),
    ("band-model-none.transmittance.paths.zenith-radians", "slant_path_at_60_degrees_is_the_vertical_path_twice"),
    ("band-model-none.transmittance.paths.km", "there_is_less_air_above_higher_altitudes"),
    ("band-model-none.transmittance.paths.altitude-double", "air_ends_at_the_top_of_the_profile"),
    ("as-printed.terms.per-um", "below_a_transparent_sky_the_scene_is_emissivity_times_planck"),
    ("as-printed.inputs.absorptance", "isothermal_air_radiates_what_it_absorbs"),
    ("as-printed.terms.double", "nothing_at_night_is_brighter_than_the_hottest_thing"),
    ("as-printed.thickness_m.double", "black_cloud_absorbs_by_its_thickness"),
    ("as-printed.inputs.cloud-low", "opaque_cloud_has_a_temperature_of_its_altitude"),
    ("as-printed.sun.azimuth-opposite", "sunlight_of_the_sea_is_irradiance_times_brdf"),
    ("as-printed.term-cloud_reflected_sun.negative", "sunlight_adds"),
    ("as-printed.sun.azimuth-dropped", "declared_sun_matters"),
    ("counting.radiance.rows-reversed", "each_quarter_is_measured_in_its_place"),
    ("counting.digital_number.inverted", "more_light_is_counted_as_more"),
    ("counting.radiance.shifted", "a_bright_spot_is_measured_where_it_is"),
    ("counting.radiance.last-row-lost", "no_row_or_column_is_lost"),
    ("counting.measure.frame.half", "seed_and_place_matter_to_noise"),
    ("counting.inputs.corner-dropped", "seed_and_place_matter_to_noise"),
    ("tracks.pixels.columns.stop-lost", "a_window_has_the_pixels_of_the_image"),
    ("tracks.pixels.columns-from-last", "an_element_is_where_the_scene_projects_it"),
    ("tracks.share.half", "the_shares_of_a_source_sum_to_one"),
    ("deck.altitude_m.feet", "the_altitude_of_an_element_is_that_of_its_place"),
    ("tracks.pixels.project.exchanged", "place_and_strength_are_those_of_a_closed_form"),
    ("deck.strength.per-um", "a_band_alone_is_as_among_others"),
    ("hot-body.temperature_K.celsius", "a_body_shines_by_its_temperature"),
    ("tracks.pixels.time_s.dropped", "place_and_strength_are_those_of_a_closed_form"),
    ("ice-map.place.rows-shifted", "the_ground_is_that_of_the_window"),
    ("ice-map.ground.exchanged", "places_are_those_that_are_known"),
    ("raster.number.rolled", "a_window_has_the_points_of_the_image"),
    ("floe.classes.reversed", "places_are_those_that_are_known"),
    ("floe.boundary.absorbed", "boundaries_obey_the_laws_of_a_sea_model"),
    ("floe.brdf.over-pi", "boundaries_obey_the_laws_of_a_sea_model"),
    ("tidal-flat.surface.time_s.dropped", "a_surface_that_is_not_still_changes"),
    ("slant.exchanged.sun_zenith-sun_azimuth", "values_are_those_of_a_closed_form"),
    ("split-window.inputs.bands-reversed", "values_are_those_of_a_closed_form"),
    ("solar-time.values.time_s.dropped", "values_are_those_of_a_closed_form"),
    ("slant.cloud_path.rolled", "a_pixel_depends_on_itself_alone"),
    ("rolling-shutter.corner.negative", "a_window_is_measured_as_the_image"),
    ("rolling-shutter.late.half", "pixels_are_measured_when_it_is_known"),
    ("rolling-shutter.late.from-ms", "the_scene_is_asked_for_as_declared"),
    ("exposure.instants.ms", "the_scene_is_asked_for_as_declared"),
)
"""Names of wrong providers and laws that refuse them."""


ACCEPTED = ("picture", "film", "flare", "coast", "raster", "plain", "in-celsius", "jitter")
"""Right providers that a kit may misjudge: given coverage, bounded times, files, light and instants at random."""


@pytest.fixture(scope="module")
def refusals():
    """Laws that refuse each case of the sample, and each accepted provider; the kit starts once."""
    wrong = [(RIGHT[WRONG[name].right], WRONG[name], law) for name, law in SAMPLE]
    right = [(RIGHT[name], None, None) for name in ACCEPTED]
    laws = [laws for laws, _ in laws_broken([*wrong, *right])]
    return dict(zip((*SAMPLE, *ACCEPTED), laws, strict=True))


@pytest.mark.parametrize(("name", "law"), SAMPLE)
def test_the_law_refuses_the_wrong_provider(refusals, name, law):
    assert refusals[name, law] == [law]


@pytest.mark.parametrize("name", ACCEPTED)
def test_the_kit_accepts_the_right_provider(refusals, name):
    assert refusals[name] == []
