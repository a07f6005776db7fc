"""Particles given by effective radius, effective variance and water content."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from own_cloud_type import own_type

from hcss_twin.core.errors import ScenarioError
from hcss_twin.models.optics import size_distribution as size
from hcss_twin.providers import Microphysics
from hcss_twin.scenario.cloud_types import PlaceLevels, resolve_layer
from hcss_twin.scenario.clouds import Layer

LEVELS = PlaceLevels(condensation_m=500.0, melting_m=3000.0, inversion_m=1500.0, tropopause_m=12_000.0)


@given(
    radius=st.floats(1.0, 200.0),
    variance=st.floats(0.02, 0.35),
    content=st.floats(1e-6, 1e-2),
    phase=st.sampled_from(["water", "ice"]),
)
def test_a_gamma_distribution_has_the_radius_variance_and_content_it_was_made_from(
    radius, variance, content, phase
) -> None:
    cloud = size.gamma_distribution(phase, radius, variance, content)
    assert size.effective_radius_um(cloud) == pytest.approx(radius, rel=1e-4)
    assert size.effective_variance(cloud) == pytest.approx(variance, rel=1e-3)
    assert size.water_content_kg_m3(cloud) == pytest.approx(content, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 0.1, 1e-4), "effective_radius_um 0.0: allowed above 0"),
        ((10.0, 0.5, 1e-4), "effective_variance 0.5: allowed above 0 and below"),
        ((10.0, 0.1, -1.0), "water_content_kg_m3 -1.0: allowed above 0"),
        ((10.0, 0.1, 1e-4, (5.0, 12.0)), "radius_range_um 5, 12: is so narrow.*closest is 0.1, 100"),
    ],
)
def test_impossible_sizes_are_refused(arguments, message) -> None:
    with pytest.raises(ValueError, match=message):
        size.gamma_distribution("water", *arguments)


def own_layer(folder, microphysics):
    return resolve_layer(
        Layer.model_validate({"type": "mine.toml"}), own_type(folder, microphysics), "clouds", LEVELS
    ).layer


def test_a_cloud_type_may_give_effective_radius_variance_and_water_content(tmp_path) -> None:
    given = "effective_radius_um = 10.0\neffective_variance = 0.1\nwater_content_kg_m3 = 3e-4"
    cloud = own_layer(tmp_path, given).microphysics
    assert size.effective_radius_um(cloud) == pytest.approx(10.0, rel=1e-6)
    assert size.water_content_kg_m3(cloud) == pytest.approx(3e-4, rel=1e-12)
    assert (cloud.alpha, cloud.nu) == (pytest.approx(7.0), 1.0)


def test_a_range_that_cuts_the_distribution_is_a_problem_of_the_cloud_type(tmp_path) -> None:
    given = (
        "effective_radius_um = 10.0\neffective_variance = 0.1\nwater_content_kg_m3 = 3e-4\nradius_range_um = [9, 11]"
    )
    with pytest.raises(ScenarioError, match=r"clouds\.type: 'mine\.toml', microphysics: radius_range_um 9, 11"):
        own_layer(tmp_path, given)


@pytest.mark.parametrize("radius", [1e-6, 1e-3, 500.0])
@pytest.mark.parametrize("variance", [0.01, 0.4])
def test_extreme_radii_and_narrow_widths_do_not_underflow(radius, variance):
    """The number follows from the third moment, r^3 (1 - v) (1 - 2 v), where the range of radii cuts nothing off."""
    cloud = size.gamma_distribution("water", radius, variance, 1e-3)
    assert size.effective_radius_um(cloud) == pytest.approx(radius, rel=5e-5)
    assert size.effective_variance(cloud) == pytest.approx(variance, rel=2e-4)
    volume = 4.0 / 3.0 * np.pi * (radius * 1e-6) ** 3 * (1.0 - variance) * (1.0 - 2.0 * variance)
    if variance == 0.01:
        assert cloud.number_density_m3 == pytest.approx(1e-3 / 1000.0 / volume, rel=1e-6)
    assert size.water_content_kg_m3(cloud) == pytest.approx(1e-3, rel=1e-12)
    radii, number = size.quadrature(cloud, 250)
    assert number @ radii**3 / (number @ radii**2) == pytest.approx(radius, rel=5e-5)


def test_a_range_without_particles_is_refused():
    far = Microphysics("water", 6.0, 1.5, 1.0, 1e8, (5000.0, 6000.0))
    with pytest.raises(ValueError, match=r"contains no particles, whose radius is about [56]"):
        size.effective_radius_um(far)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("number_density", 1e-300, r"microphysics: number_density 1e-300 m-3 .* allowed: 1e-09 to 0\.1"),
        ("number_density", 1e12, r"microphysics: number_density 1e\+12 m-3 .* allowed: 1e-09 to 0\.1"),
        ("nu", 0.01, r"microphysics\.nu: 0\.01 is out of range; allowed: >= 0\.1"),
        ("b", 1e300, r"microphysics\.b: 1e\+300 is out of range; allowed: >= 1e-06"),
        ("b", 1e6, r"microphysics: radius_range_um .* contains no particles"),
        ("radius_range_um", [1e-300, 1e300], r"microphysics\.radius_range_um: .* allowed: 1e-6 <= smallest"),
        ("density", 1e-300, r"microphysics\.density: 1e-300 is out of range; allowed: >= 1"),
    ],
)
def test_particles_beyond_limits_are_refused_by_key(key, value, message, tmp_path) -> None:
    keys = {"alpha": 3.0, "b": 0.193, "nu": 1.3, "number_density": 80e6, "radius_range_um": [0.02, 50.0], key: value}
    with pytest.raises(ScenarioError, match=message):
        own_layer(tmp_path, "\n".join(f"{name} = {each}" for name, each in keys.items()))
