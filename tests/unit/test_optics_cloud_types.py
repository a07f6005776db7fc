"""Cloud-type files have the agreed keys and the numbers of Table III of the HCSS paper."""

from pathlib import Path

import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics import size_distribution as size
from hcss_twin.providers import Microphysics
from hcss_twin.scenario.cloud_types import load_cloud_type

ROOT = Path(__file__).parents[2]

KEYS = {
    "layer": {"material", "base", "top", "anchor", "thickness_min"},
    "fractal": {"gamma", "H", "L", "k"},
    "microphysics": {"alpha", "b", "nu", "number_density", "radius_range_um", "source"},
}
TABLE_III = {
    "paper-stratus": (3, 0.8, [10, 10], [0, 4], 33.0, 1000.0),
    "paper-cumulus": (3, 0.7, [30, 30], [0, 7], 66.0, 3000.0),
    "paper-cirrus": (3, 0.8, [50, 10], [0, 4], 6000.0, 10000.0),
    "paper-simulated": (4, 0.8, [3, 7], [0, 10], 333.0, 6000.0),
}
EFFECTIVE = {
    "stratus": 11.28,
    "paper-stratus": 11.28,
    "stratocumulus": 11.28,
    "cumulus": 12.68,
    "paper-cumulus": 12.68,
    "paper-simulated": 12.68,
    "cirrus": 30.0,
    "paper-cirrus": 30.0,
    "deep-convection": 30.0,
    "altostratus": 30.0,
    "altocumulus": 7.33,
    "fog": 10.72,
    "thick-fog": 7.33,
}


def read(name: str) -> dict:
    catalog = Catalog()
    return catalog.toml(catalog.find(name, "cloud_types", ".toml"))


HANGING = {"deep-convection", "stratus", "stratocumulus"}
"""Types with flat tops."""


@pytest.mark.parametrize("name", sorted(EFFECTIVE))
def test_cloud_type_has_exactly_the_agreed_keys(name) -> None:
    data = read(name)
    assert set(data) - {"optical_thickness", "sky"} == {"title", "description", "source", "pixel_size_max", *KEYS}
    for table, keys in KEYS.items():
        by_place = {"level", "depth"} if table == "layer" and "level" in data[table] else set()
        fixed = {"base", "top"} if by_place else set()
        assert set(data[table]) - {"brightness_exponent", "offset"} == (keys - fixed) | by_place
    layer = data["layer"]
    assert layer["anchor"] == ("top" if name in HANGING else "base")
    depth = layer["depth"] if "depth" in layer else layer["top"] - layer["base"]
    assert 0 < layer["thickness_min"] < depth


@pytest.mark.parametrize("name", ["stratus", "stratocumulus", "cumulus", "cirrus", "deep-convection"])
def test_clouds_are_as_thick_as_published(name) -> None:
    cloud = load_cloud_type(name, Catalog())
    least, greatest = cloud.optical_thickness.published
    assert least <= cloud.visible_optical_thickness(cloud.optical_thickness.of) <= greatest
    # Those of the paper are not.
    assert load_cloud_type("paper-cumulus", Catalog()).visible_optical_thickness("median") > 70.0


@pytest.mark.parametrize("name", sorted(TABLE_III))
def test_cloud_type_carries_table_iii(name) -> None:
    data = read(name)
    fractal, layer = data["fractal"], data["layer"]
    found = (fractal["gamma"], fractal["H"], fractal["L"], fractal["k"], layer["base"], layer["top"])
    assert found == TABLE_III[name]


# Hess et al. (1998), Table 1b: mode radius in um, alpha, nu, B, number in cm-3; water in g m-3, effective radius in um.
OPAC = {
    "stratus, maritime": (6.75, 3.0, 1.30, 0.193, 80.0, 0.30, 11.3),
    "stratus, continental": (4.7, 5.0, 1.05, 0.938, 250.0, 0.28, 7.33),
    "cumulus, maritime": (10.4, 4.0, 2.34, 0.00713, 65.0, 0.44, 12.68),
    "cumulus, continental clean": (4.8, 5.0, 2.16, 0.0782, 400.0, 0.26, 5.77),
    "cumulus, continental polluted": (3.53, 8.0, 2.15, 0.247, 1300.0, 0.30, 4.00),
    "fog": (8.06, 4.0, 1.77, 0.0562, 15.0, 0.058, 10.7),
}


@pytest.mark.parametrize("name", OPAC)
def test_the_guide_lists_the_sizes_of_published_water_clouds(name) -> None:
    mode, alpha, nu, b, number, water, radius = OPAC[name]
    cloud = Microphysics("water", alpha, b, nu, 1e6 * number, (0.02, 50.0))
    assert (alpha / (b * nu)) ** (1.0 / nu) == pytest.approx(mode, rel=2e-3)
    assert size.effective_radius_um(cloud) == pytest.approx(radius, rel=3e-3)
    assert 1e3 * size.water_content_kg_m3(cloud) == pytest.approx(water, rel=0.02)
    guide = (ROOT / "docs" / "how-to" / "clouds.md").read_text(encoding="utf-8")
    row = next(line for line in guide.splitlines() if line.startswith(f"| {name}"))
    told = [float(cell) for cell in row.split("|")[2:5]]
    found = [size.effective_radius_um(cloud), size.effective_variance(cloud), 1e3 * size.water_content_kg_m3(cloud)]
    assert told == pytest.approx(found, rel=0.02)


@pytest.mark.parametrize("name", sorted(EFFECTIVE))
def test_cloud_type_has_the_effective_radius_its_header_states(name) -> None:
    data = read(name)
    particles = data["microphysics"]
    cloud = Microphysics(
        data["layer"]["material"],
        particles["alpha"],
        particles["b"],
        particles["nu"],
        particles["number_density"],
        tuple(particles["radius_range_um"]),
    )
    assert size.effective_radius_um(cloud) == pytest.approx(EFFECTIVE[name], rel=5e-4)
