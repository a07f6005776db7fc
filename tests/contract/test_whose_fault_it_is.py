"""Every error of a provider names provider, member and arguments, and no key of the scenario but its own."""

import numpy as np
import pytest
from cheap import CHEAP
from hcss_author import (
    sample_cloud_inputs,
    sample_element_inputs,
    sample_microphysics,
    sample_motion,
    sample_radiance_inputs,
    sample_sensor_inputs,
    sample_variable_inputs,
)

from hcss_twin import ProviderError, Scenario, ScenarioError, make_plan
from hcss_twin.core.errors import CatalogError, ProviderDefect
from hcss_twin.models.clouds.fractal.generator import FractalClouds
from hcss_twin.models.optics.mie import MieOptics
from hcss_twin.models.radiance.as_printed import AsPrinted
from hcss_twin.models.sea.cox_munk import CoxMunkSea
from hcss_twin.physics.paths import to_space
from hcss_twin.plan.builder import attribute_to_field
from hcss_twin.providers import AtmosphereDeclaration, ColumnStates, Grid, Points
from hcss_twin.providers.registry import Entry, Kind, Origin, ProviderSpec
from hcss_twin.providers.registry.guard import guard

NU, MU, PATHS = np.array([800.0, 1000.0, 2500.0]), np.array([1.0, 0.5]), [to_space(0.0, 0.0), to_space(0.0, 60.0)]
VERTICAL = {"shadows": "off", "parallax": "off"}
WINDOW = slice(0, 4), slice(0, 5)
GRID = Grid(4, 5, 100.0)
SPECTRAL = "wavenumber_cm1 of shape (3,)"

POINTS = Points(*np.ones((4, 1)), np.ones((1, 1)))
STATES = ColumnStates.product([sample_radiance_inputs().setting], np.ones((4, 1)))

# Of each member of each kind: arguments, and what an error says of them.
MEMBERS = {
    ("clouds", "thickness_m"): ((0.0, *WINDOW), "time_s = 0.0, rows = slice(0, 4, None)"),
    ("clouds", "frame_summary"): ((0.0,), "time_s = 0.0"),
    ("clouds", "thickness_in_frame_m"): ((0.0, *WINDOW, None), "columns = slice(0, 5, None), summary = None"),
    ("clouds", "thickness_around_m"): ((0.0, *WINDOW, None), "summary = None"),
    ("clouds", "cloud_top_m"): ((0.0, *WINDOW), "time_s = 0.0, rows = slice(0, 4, None)"),
    ("clouds", "cloud_depth_m"): ((0.0, *WINDOW), "time_s = 0.0, rows = slice(0, 4, None)"),
    ("clouds", "height_shares"): (
        (0.0, *WINDOW, np.ones((4, 5)), np.array([0.0, 500.0, 1000.0])),
        "thickness_m of shape (4, 5), edges_m of shape (3,)",
    ),
    ("sea", "emissivity"): ((NU, MU), f"{SPECTRAL}, mu of shape (2,)"),
    ("sea", "brdf"): ((NU, MU, MU, MU), "mu_in of shape (2,), relative_azimuth of shape (2,)"),
    ("sea", "reflection_weights"): ((NU, MU, MU), "mu_nodes of shape (2,)"),
    ("sea", "wave_slope_rms"): ((10.0,), "pixel_size_m = 10.0"),
    ("sea", "wave_field"): ((GRID, sample_motion(), 1), "grid a Grid, motion a Motion, seed = 1"),
    ("sea", "tilted"): ((0.1, 0.2, 10.0), "upwind = 0.1, crosswind = 0.2"),
    ("optics", "single_scattering"): ((sample_microphysics(), NU), f"cloud a Microphysics, {SPECTRAL}"),
    ("atmosphere", "transmittance"): ((NU, PATHS), f"{SPECTRAL}, paths of length 2"),
    ("atmosphere", "path_radiance"): ((NU, PATHS), f"{SPECTRAL}, paths of length 2"),
    ("atmosphere", "solar_path_radiance"): ((NU, PATHS, 30.0, 0.0), "paths of length 2, arguments of length 2"),
    ("atmosphere", "absorber_amounts"): ((PATHS,), "paths of length 2"),
    ("atmosphere", "transmittance_of_amounts"): ((NU, np.ones((2, 7))), "amounts of shape (2, 7)"),
    ("atmosphere", "scattering_of_amounts"): ((NU, np.ones((2, 7))), "amounts of shape (2, 7)"),
    ("atmosphere", "vapour_kinks"): ((0.8, 1.2), "low = 0.8, high = 1.2"),
    ("radiance", "columns"): ((STATES, NU), f"states a ColumnStates, {SPECTRAL}"),
    ("elements", "pixels"): ((0.0, *WINDOW, None), "scene = None"),
    ("surfaces", "surface"): ((0.0, *WINDOW), "time_s = 0.0"),
    ("variables", "values"): (
        ({"radiance": np.ones((2, 4, 5))}, 0.0),
        "fields with radiance of shape (2, 4, 5), time_s",
    ),
    ("sensors", "measure"): ((np.ones((1, 4, 5)), 0, 0.0), "radiance of shape (1, 4, 5), frame = 0"),
    ("sensors", "measure_with"): ((np.ones((1, 4, 5)), POINTS, 0, 0.0), "points a Points, frame = 0"),
    ("sensors", "points_after"): ((POINTS,), "points a Points"),
}
INPUTS = {
    "clouds": sample_cloud_inputs(),
    "elements": sample_element_inputs(),
    "variables": sample_variable_inputs(),
    "sensors": sample_sensor_inputs(),
}


def guarded(kind, **members):
    spec = ProviderSpec("toy", "a:B", None, 3, "a toy")
    common = {"declares": AtmosphereDeclaration(), "variables": (), "terms": {"a": "b"}, "solar_terms": frozenset()}
    common["cloud_top_range_m"] = 0.0, 1e4
    provider = type("Toy", (), {**common, **members})()
    return guard(Entry(Kind(kind), spec, Origin("a", "hcss-a", "1.2")), provider, INPUTS.get(kind))


UNCHECKED = ("frame_summary", "tilted", "wave_field")
"""Members whose results are what the provider likes, or objects that are checked when they are used."""


def raising(error):
    def member(*_, **__):
        raise error

    return member


def test_every_method_of_every_kind_is_tried():
    import hcss_twin.providers as api

    found = set()
    for kind in Kind:
        for name in (kind.protocol, f"{kind.protocol}Options".replace("TransmittanceProviderO", "TransmittanceO")):
            members = vars(getattr(api, name, object))
            found |= {(str(kind), each) for each, value in members.items() if callable(value) and each[0] != "_"}
    assert found - {("atmosphere", "bound_profile")} == set(MEMBERS)  # the registry calls that one


@pytest.mark.parametrize(("kind", "member"), MEMBERS)
@pytest.mark.parametrize(
    ("error", "raised"), [(ZeroDivisionError("by nothing"), ProviderDefect), (CatalogError("no file"), CatalogError)]
)
def test_error_names_provider_member_and_arguments(kind, member, error, raised):
    arguments, shown = MEMBERS[kind, member]
    with pytest.raises(raised) as caught:
        getattr(guarded(kind, **{member: raising(error)}), member)(*arguments)
    text = str(caught.value)
    assert text.startswith(f"{Kind(kind).human} 'toy' of hcss-a 1.2: {member}()")
    assert str(error) in text
    assert shown in text
    assert caught.value.__cause__ is error


@pytest.mark.parametrize(("kind", "member"), [each for each in MEMBERS if each[1] not in UNCHECKED])
def test_wrong_result_names_provider_member_and_arguments(kind, member):
    arguments, shown = MEMBERS[kind, member]
    asked = getattr(guarded(kind, **{member: lambda *_, **__: "text"}), member)
    with pytest.raises(ProviderDefect, match=rf"'toy' of hcss-a 1\.2: .*{member}\(\).* broke its contract") as caught:
        asked(*arguments)
    assert shown in str(caught.value)


def test_attribute_that_cannot_be_read_names_provider_and_attribute():
    sea = guarded("sea", significant_wave_height_m=property(raising(ZeroDivisionError("by nothing"))))
    with pytest.raises(ProviderDefect, match=r"'toy' of hcss-a 1\.2: reading significant_wave_height_m raised Zero"):
        sea.significant_wave_height_m  # noqa: B018


@pytest.mark.parametrize("error", [ZeroDivisionError("by nothing"), ProviderError("no such path")])
def test_provider_within_another_one_is_at_fault_alone(error):
    gas = guarded("atmosphere", transmittance=raising(error))
    model = guarded("radiance", columns=lambda self, states, wavenumber: gas.transmittance(wavenumber, PATHS))
    with pytest.raises(ProviderError) as caught:
        model.columns(STATES, NU)
    assert str(caught.value).startswith("transmittance provider 'toy' of hcss-a 1.2: transmittance()")
    assert "radiance model" not in str(caught.value)


def test_parameter_that_has_the_name_of_the_provider_is_not_at_fault():
    gas = guarded("atmosphere", transmittance=raising(CatalogError("no data")))
    with pytest.raises(ScenarioError) as caught, attribute_to_field("atmosphere.provider", {"file": "toy"}):
        gas.transmittance(NU, PATHS)
    assert [problem.field for problem in caught.value.problems] == ["atmosphere.provider"]


SMALL = {**CHEAP, "image.rows": 8, "image.columns": 8, "frames.count": 2, "bands": ["lwir-10.8"]}


@pytest.mark.parametrize(
    ("owner", "member", "overrides"),
    [
        (MieOptics, "single_scattering", {}),
        (CoxMunkSea, "emissivity", {}),
        (AsPrinted, "columns", {}),
        (FractalClouds, "thickness_m", {"clouds.coverage_mode": "field", "slant": VERTICAL}),
    ],
)
def test_plan_with_a_provider_that_fails_names_no_key(monkeypatch, owner, member, overrides):
    monkeypatch.setattr(owner, member, raising(ZeroDivisionError("by nothing")))
    with pytest.raises(ProviderDefect, match=rf"{member}\(\) raised ZeroDivisionError: by nothing.*; arguments: \w"):
        make_plan(Scenario.load("stratus", {**SMALL, **overrides}), keeps_results=False)


def test_accident_at_the_last_frame_or_with_a_low_sun_is_no_problem_of_frames_or_time(monkeypatch):
    good = FractalClouds.thickness_m

    def late(self, time_s, rows, columns):
        return good(self, time_s, rows, columns) if time_s == 0.0 else 1 / 0

    monkeypatch.setattr(FractalClouds, "thickness_m", late)
    with pytest.raises(ProviderDefect, match=r"thickness_m\(\) raised ZeroDivisionError"):
        make_plan(
            Scenario.load("stratus", {**SMALL, "clouds.coverage_mode": "field", "slant": VERTICAL}), keeps_results=False
        )
