"""Evidence of a cube: rows are those of its scene, and each has a source that says what the row says."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.core.own_packages import PROVIDERS
from hcss_twin.cube.sensor_cube import SENSOR_ATTRIBUTE
from hcss_twin.providers.registry.registry import Registry
from hcss_twin.providers.registry.specs import Kind
from hcss_twin.reports.evidence import Evidence, EvidenceCatalog, tags_of

ROOT = Path(__file__).parents[2]
CATALOG = EvidenceCatalog.read()
BANDS = {"swir": (2.7, 3.0), "mwir": (3.4, 4.2), "lwir": (10.3, 11.3)}
DAY, NIGHT = (30.0, 31.0), (110.0, 111.0)
SUNLIT = {"sunlit cloud", "glint", "shadows", "sunlit air"}


def attributes(*, clouds=("stratus", "water"), radiance="physical", **scenario):
    """Attributes as cubes have them."""
    own = {"distribution": "hcss-twin", "version": "0"}
    names = {
        "atmosphere": "band-model",
        "sea": "rough-sea",
        "optics": "bulk",
        "clouds": "fractal",
        "radiance": radiance,
    }
    layers = [{"type": clouds[0], "coverage": 0.5}] if clouds else []
    given = {"atmosphere": {"coefficients": "rrtmgp"}, "clouds": {"layers": layers}, "surfaces": None, "elements": []}
    return {
        "hcss_scenario": json.dumps(given | scenario),
        "hcss_providers": json.dumps({kind: {"name": name, **own} for kind, name in names.items()}),
        "hcss_particles": json.dumps([{"name": clouds[0], "material": clouds[1]}] if clouds else []),
    }


def evidence(sun=DAY, bands=None, **scene):
    given = attributes(**scene)
    return Evidence(given, BANDS if bands is None else bands, tags_of(given, sun), sun, CATALOG)


def names(found):
    return {quantity.name for quantity in found.quantities}


def references(found, quantity):
    return [row for row in found.comparisons if row.quantity == quantity]


def test_every_source_exists_and_says_what_the_row_quotes():
    for row in (*CATALOG.comparisons, *CATALOG.unmeasured):
        text = (ROOT / row.source).read_text(encoding="utf-8")
        assert " ".join(row.quote.split()) in " ".join(text.split()), f"{row.source}: {row.quote}"


def test_numbers_of_a_row_are_those_of_its_quote_or_of_the_source():
    """A figure that the source states otherwise is a figure of nobody."""
    for row in CATALOG.comparisons:
        text = (ROOT / row.source).read_text(encoding="utf-8")
        for number in (word.strip("(),;") for word in row.figure.split()):
            if number.replace(".", "", 1).lstrip("+-").isdigit() and row.source.endswith(".md"):
                assert number.lstrip("+-") in text, f"{row.source}: {number}"


def test_a_night_has_no_sunlit_rows_and_a_day_has():
    assert names(evidence(DAY)) >= SUNLIT
    assert not SUNLIT & names(evidence(NIGHT))
    assert names(evidence((80.0, 100.0))) >= SUNLIT  # a sunset
    assert not {row.quantity for row in evidence(NIGHT).comparisons} & SUNLIT


def test_bands_without_sunlight_have_no_sunlit_rows():
    assert not SUNLIT & names(evidence(DAY, {"lwir": (8.0, 14.0)}))


def test_no_measurement_supports_sunlight_in_any_band():
    rows = [row for row in evidence(DAY).support if row.quantity.name in SUNLIT]
    assert {row.band for row in rows} == {"swir", "mwir"}
    assert all(row.measured == 0.0 and "measurement" not in row.kinds for row in rows)
    assert {row.quantity.name for row in evidence(DAY).unsupported} >= SUNLIT


def test_rows_follow_clouds_and_surface():
    assert not {"opaque cloud", "sides", "shadows", "cloud fields"} & names(evidence(clouds=None))
    assert "droplets" in names(evidence())
    assert "crystals" not in names(evidence())
    ice = names(evidence(clouds=("cirrus", "ice")))
    assert "crystals" in ice
    assert "temperature of low cloud" not in ice
    assert "land" not in names(evidence())
    assert "land" in names(evidence(surfaces={"provider": "coast"}))
    assert "elements" in names(evidence(elements=[{"model": "points"}]))


def test_evidence_of_a_model_does_not_stand_behind_another():
    assert references(evidence(), "clear sky")
    assert not references(evidence(radiance="as-printed"), "clear sky")


def test_a_provider_of_another_package_with_a_known_name_has_no_evidence():
    given = attributes()
    providers = json.loads(given["hcss_providers"])
    providers["radiance"]["distribution"] = "somebodys-package"
    assert "physical" not in tags_of(given | {"hcss_providers": json.dumps(providers)}, DAY)


@pytest.mark.parametrize(
    ("bands", "share"),
    [
        ({"b": (10.23, 11.33)}, 1.0),
        ({"b": (9.13, 11.33)}, 0.5),
        ({"b": (8.0, 14.0)}, (0.43 + 1.10 + 1.04 + 1.00) / 6.0),
        ({"b": (2.7, 3.0)}, 0.0),
    ],
)
def test_a_band_is_supported_by_the_share_that_measurements_cover(bands, share):
    (row,) = (row for row in evidence(bands=bands).support if row.quantity.name == "clear sky")
    assert row.measured == pytest.approx(share, abs=1e-6)


def test_a_comparison_that_the_model_failed_supports_nothing():
    def fields(scene):
        (row,) = (row for row in scene.support if row.quantity.name == "cloud fields")
        return row

    told_apart = fields(evidence())  # fractal clouds are always told from measured images
    assert (told_apart.measured, told_apart.failed) == (0.0, ("measurement",))
    assert "measurement" not in told_apart.kinds
    assert "cloud fields" in {row.quantity.name for row in evidence().unsupported}
    passed = replace(CATALOG, comparisons=tuple(replace(row, failed=False) for row in CATALOG.comparisons))
    scene = evidence()
    same = fields(replace(scene, catalog=passed))
    assert (same.measured, same.failed) == (1.0, ())
    rows = [row for row in scene.as_dict()["support"] if row["failed"]]
    assert [row["quantity"] for row in rows] == ["Shapes and structure of cloud fields"]


def test_comparisons_at_other_wavelengths_are_not_shown():
    at = references(evidence(bands={"b": (10.5, 11.0)}), "clear sky")
    assert {row.um for row in at} == {(10.23, 11.33)}


def test_low_cloud_is_measured_for_its_type_and_inversion_only():
    def figures(kind, **air):
        scene = evidence(clouds=(kind, "water"), atmosphere={"coefficients": "rrtmgp", **air})
        return [row.figure for row in references(scene, "temperature of low cloud")]

    assert figures("stratus") == []
    assert len(figures("stratocumulus")) == 1
    assert figures("stratocumulus", inversion="off") == []


def test_the_budget_lists_references_largest_first_and_names_what_is_unknown():
    part = {"known": 1.0, "statistic": "rms", "recomputed": True, "needs": ""}
    parts = [
        {"name": "engine", "relative": 1e-4, "kelvin": 0.01, "sources": [], **part},
        {"name": "gas", "relative": 0.02, "kelvin": 0.5, "sources": ["RRTMGP"], **part},
        {"name": "sea", "relative": None, "kelvin": None, "sources": [], **part},
    ]
    cell = {"at_least": 0.02, "at_least_K": 0.5, "unknown": ["sea"], "contributions": parts}
    given = attributes() | {"hcss_error_budget": json.dumps({"stratus": {"mwir": cell}})}
    found = Evidence(given, BANDS, tags_of(given, DAY), DAY, CATALOG)
    assert [row["model"] for row in found.budget] == ["total", "gas", "engine", "sea"]
    assert found.budget[0]["statistic"] == "at least"
    assert [row["references"] for row in found.budget[1:]] == [["RRTMGP"], ["certificate of this cube"], []]
    assert "clear sky" not in names(found)  # no class of clear pixels
    json.dumps(found.as_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ('[[quantity]]\nname = "x"\ntitle = "y"\nband = 3\n', "quantity 'x': .*band"),
        ('[[quantity]]\nname = "x"\n', "quantity 'x': .*title"),
        ('[[unmeasured]]\nwhat = "rain"\n', "unmeasured 'rain': .*source"),
    ],
)
def test_a_row_with_wrong_keys_is_refused_by_name(row, message, tmp_path):
    (tmp_path / "evidence.toml").write_text(row)
    with pytest.raises(CatalogError, match=message):
        EvidenceCatalog.read(tmp_path / "evidence.toml")


def test_a_comparison_of_an_unknown_quantity_or_kind_is_refused(tmp_path):
    text = (ROOT / "catalogs" / "evidence.toml").read_text(encoding="utf-8")
    for old, new, message in (
        ('kind = "own code"', 'kind = "hearsay"', "kind 'hearsay'; allowed: measurement"),
        ('quantity = "glint"', 'quantity = "glitter"', "quantity 'glitter'; allowed: .*glint"),
    ):
        (tmp_path / "evidence.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(CatalogError, match=message):
            EvidenceCatalog.read(tmp_path / "evidence.toml")


def test_a_layer_of_no_coverage_is_no_cloud():
    given = attributes()
    scenario = json.loads(given["hcss_scenario"])
    scenario["clouds"]["layers"][0]["coverage"] = 0.0
    assert not {"cloud", "water", "type stratus"} & tags_of(given | {"hcss_scenario": json.dumps(scenario)}, DAY)


def test_every_word_of_the_catalog_is_one_that_a_scene_can_have():
    """A word with a spelling mistake would hide its row from every scene."""
    registry, found = Registry.defaults_only(), set(PROVIDERS)
    for kind in Kind:
        found |= {name.rpartition("/")[2] for name in registry.names(kind)}
    found |= {f"type {name}" for name in Catalog().names("cloud_types", ".toml")}
    air = {"coefficients": "rrtmgp", "inversion": {}, "water_vapour_texture": 0.1}
    full = attributes(atmosphere=air, surfaces={}, elements=[{}]) | {"hcss_light": "{}", SENSOR_ATTRIBUTE: "{}"}
    found |= tags_of(full, (80.0, 100.0)) | tags_of(attributes(clouds=("cirrus", "ice")), NIGHT) | {"lowtran7"}
    for row in (*CATALOG.quantities, *CATALOG.comparisons, *CATALOG.unmeasured):
        assert found.issuperset(row.when), row
