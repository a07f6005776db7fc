"""A layer of a scenario may change the particles of its cloud type."""

import pytest
from own_cloud_type import own_type
from refusals import problems_of

from hcss_twin import Scenario, ScenarioError, make_plan
from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics import size_distribution as size
from hcss_twin.scenario.cloud_types import PlaceLevels, resolve_layer
from hcss_twin.scenario.clouds import Layer

LEVELS = PlaceLevels(condensation_m=500.0, melting_m=3000.0, inversion_m=1500.0, tropopause_m=12_000.0)
TINY = {"image.rows": 8, "image.columns": 8, "frames.count": 2}
BY_SIZE = "effective_radius_um = {}\neffective_variance = {}\nwater_content_kg_m3 = {}"


def particles(catalog=None, **keys):
    return resolve_layer(Layer.model_validate(keys), catalog or Catalog(), "clouds", LEVELS).layer.microphysics


@pytest.mark.parametrize("material", ["water", "ice"])
@pytest.mark.parametrize("variance", [0.01, 0.15, 0.4])
def test_particles_given_in_the_scenario_are_those_of_the_same_type_file(tmp_path, variance, material):
    catalog = own_type(tmp_path, BY_SIZE.format(12.0, variance, 3e-4), material)
    given = particles(
        type="stratus", material=material, effective_radius=12.0, effective_variance=variance, water_content=0.3
    )
    assert given == particles(catalog, type="mine.toml")


def test_what_the_scenario_leaves_out_is_that_of_the_type_file(tmp_path):
    catalog = own_type(tmp_path, BY_SIZE.format(12.0, 0.15, 3e-4))
    for key, value, changed in (
        ("effective_radius", 20.0, (20.0, 0.15, 3e-4)),
        ("effective_variance", 0.3, (12.0, 0.3, 3e-4)),
        ("material", "ice", (12.0, 0.15, 3e-4)),
    ):
        found = particles(catalog, type="mine.toml", **{key: value})
        assert found == size.gamma_distribution("ice" if key == "material" else "water", *changed)


def test_of_a_type_by_shape_radius_and_content_stay_as_they_were_measured():
    usual = particles(type="stratus")
    found = particles(type="stratus", effective_radius=8.0)
    assert size.effective_radius_um(found) == pytest.approx(8.0, rel=1e-5)
    for measure in (size.effective_variance, size.water_content_kg_m3):
        assert measure(found) == pytest.approx(measure(usual), rel=1e-3)


def test_a_water_content_alone_changes_only_how_many_particles_there_are():
    usual, found = particles(type="stratus"), particles(type="stratus", water_content=0.6)
    shape = ("material", "alpha", "b", "nu", "radius_range_um")
    assert [getattr(found, key) for key in shape] == [getattr(usual, key) for key in shape]
    assert size.water_content_kg_m3(found) == pytest.approx(6e-4, rel=1e-12)


def test_a_material_alone_keeps_sizes_and_mass():
    usual, found = particles(type="cirrus"), particles(type="cirrus", material="water")
    assert found.material == "water"
    assert size.effective_radius_um(found) == size.effective_radius_um(usual)
    assert size.water_content_kg_m3(found) == pytest.approx(size.water_content_kg_m3(usual), rel=1e-12)


@pytest.mark.parametrize(
    ("value", "plain"),
    [("effective_radius='12 um'", 12.0), ("effective_radius='12000 nm'", 12.0), ("water_content='3e-4 kg/m3'", 0.3)],
)
def test_sizes_and_contents_may_have_units(value, plain):
    key, text = value.split("=")
    layer = Layer.model_validate({key: text.strip("'")})
    assert getattr(layer, key) == pytest.approx(plain, rel=1e-12)


def refusal(overrides, scenario="stratus"):
    return problems_of(lambda: make_plan(Scenario.load(scenario, {**TINY, **overrides})))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("effective_radius", 600.0, "allowed: >= 0.001 and <= 500; closest valid choice is 500"),
        ("effective_radius", 0.0, "allowed: >= 0.001 and <= 500; closest valid choice is 0.001"),
        ("effective_radius", "12 m", "'m' is not a unit of particle radius"),
        ("effective_variance", 0.5, "allowed: >= 0.01 and <= 0.4; closest valid choice is 0.4"),
        ("effective_variance", "0.1", "'0.1' is not a number"),
        ("water_content", "300 kg/m3", "= 300000 is out of range; allowed: >= 1e-06 and <= 100"),
        ("water_content", "0.3 g", "'g' is not a unit of water content"),
        ("material", "wader", "closest is 'water'"),
        ("effectiv_radius", 3.0, "closest is 'effective_radius'"),
    ],
)
def test_errors_name_the_key_of_the_layer(key, value, message):
    assert message in refusal({f"clouds.{key}": value})[f"clouds.{key}"]
    assert message in refusal({f"clouds.layers.1.{key}": value}, "cirrus-over-cumulus")[f"clouds.layers[1].{key}"]


def test_all_that_is_wrong_with_the_particles_is_told_at_once():
    wrong = {"clouds.effective_radius": 0, "clouds.effective_variance": 1, "clouds.water_content": -1}
    assert set(refusal(wrong)) == set(wrong)


def test_particles_that_the_optics_do_not_have_are_a_problem_of_their_key():
    overrides = {"optics.provider": "bulk", "clouds.effective_radius": 120.0}
    found = refusal(overrides, "cirrus")
    assert "closest is 96.03" in found["clouds.effective_radius"]
    found = refusal({"optics.provider": "bulk", "clouds.material": "ice", "clouds.effective_radius": 2.0})
    assert "closest is 5.442" in found["clouds.effective_radius"]


def test_a_variance_of_the_type_that_no_gamma_distribution_may_have_is_asked_for(tmp_path):
    catalog = own_type(
        tmp_path, "alpha = 0.0\nb = 3.0\nnu = 0.5\nnumber_density = 80.0e6\nradius_range_um = [0.01, 1000.0]"
    )
    with pytest.raises(ScenarioError, match=r"clouds\.effective_variance: is missing.*closest valid choice is 0\.4"):
        particles(catalog, type="mine.toml", effective_radius=10.0)
    assert particles(catalog, type="mine.toml", effective_radius=10.0, effective_variance=0.4).nu == 1.0
