"""Cloud-type files have the agreed keys and the numbers of Table III of the HCSS paper."""

import pytest

from hcss_twin.core.catalog import Catalog
from hcss_twin.models.optics import size_distribution as size
from hcss_twin.providers import Microphysics

KEYS = {
    "layer": {"phase", "base", "top", "anchor", "thickness_min"},
    "fractal": {"gamma", "H", "L", "k"},
    "microphysics": {"alpha", "b", "nu", "number_density", "radius_range_um", "source"},
}
TABLE_III = {
    "stratus": (3, 0.8, [10, 10], [0, 4], 33.0, 1000.0),
    "cumulus": (3, 0.7, [30, 30], [0, 7], 66.0, 3000.0),
    "cirrus": (3, 0.8, [50, 10], [0, 4], 6000.0, 10000.0),
    "simulated": (4, 0.8, [3, 7], [0, 10], 333.0, 6000.0),
}
EFFECTIVE = {"stratus": 11.28, "stratocumulus": 11.28, "cumulus": 12.68, "simulated": 12.68, "cirrus": 30.0}


def read(name: str) -> dict:
    catalog = Catalog()
    return catalog.toml(catalog.find(name, "cloud_types", ".toml"))


@pytest.mark.parametrize("name", sorted(EFFECTIVE))
def test_cloud_type_has_exactly_the_agreed_keys(name) -> None:
    data = read(name)
    assert set(data) == {"title", "description", "source", *KEYS}
    for table, keys in KEYS.items():
        assert set(data[table]) == keys
    assert data["layer"]["anchor"] == "base"
    assert 0 < data["layer"]["thickness_min"] < data["layer"]["top"] - data["layer"]["base"]


@pytest.mark.parametrize("name", sorted(TABLE_III))
def test_cloud_type_carries_table_iii(name) -> None:
    data = read(name)
    fractal, layer = data["fractal"], data["layer"]
    found = (fractal["gamma"], fractal["H"], fractal["L"], fractal["k"], layer["base"], layer["top"])
    assert found == TABLE_III[name]


@pytest.mark.parametrize("name", sorted(EFFECTIVE))
def test_cloud_type_has_the_effective_radius_its_header_states(name) -> None:
    data = read(name)
    particles = data["microphysics"]
    cloud = Microphysics(
        data["layer"]["phase"],
        particles["alpha"],
        particles["b"],
        particles["nu"],
        particles["number_density"],
        tuple(particles["radius_range_um"]),
    )
    assert size.effective_radius_um(cloud) == pytest.approx(EFFECTIVE[name], rel=5e-4)
