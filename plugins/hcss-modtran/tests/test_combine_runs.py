import numpy as np
import pytest
from hcss_modtran.combine import combine, surface_zenith_deg
from hcss_modtran.importing import ReadOptions, detect_format, parse_geometry, read_paths
from hcss_modtran.spectral_path import PathGeometry, SpectralPath
from tape7_text import air, radiance_run, transmittance_run, write

from hcss_twin.core.catalog import Catalog
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.profile_file import load_profile
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.physics.planck import planck
from hcss_twin.physics.profile import EARTH_RADIUS_M

WAVENUMBER = np.arange(800.0, 1000.5, 10.0)


@pytest.fixture(scope="module")
def profile():
    return load_profile("us-standard-1976", Catalog())


def path(observer_km=100.0, end_km=0.0, angle_deg=180.0, depth=0.5, temperature_K=250.0, **changed):
    sight = PathGeometry(observer_km * 1e3, end_km * 1e3, angle_deg)
    tau = np.full(WAVENUMBER.size, np.exp(-depth))
    values = {
        "wavenumber_cm1": WAVENUMBER,
        "transmittance": tau,
        "path_radiance": (1 - tau) * planck(WAVENUMBER, temperature_K),
        "geometry": sight,
        "code": "test",
        "source": f"{sight}",
        "line": 12,
        **changed,
    }
    return SpectralPath(**values)


def grid():
    """Three heights, three angles from 100 km downwards; depth falls with height and rises with angle."""
    return [
        path(end_km=height, angle_deg=angle, depth=0.5 * np.exp(-height / 2) / np.cos(np.radians(180 - angle)))
        for height in (0.0, 1.0, 3.0)
        for angle in (180.0, 150.0, 130.0)
    ]


def test_ray_from_space_arrives_refracted(profile):
    # Bending of a ray at 45 deg is the refractivity times tan 45 deg; spherical layers change it by 0.1 %.
    arrival = 45.0
    height = 100e3
    sine = np.sin(np.radians(arrival)) * EARTH_RADIUS_M / (EARTH_RADIUS_M + height)
    straight = 180.0 - np.degrees(np.arcsin(sine))
    _, zenith = surface_zenith_deg(path(angle_deg=straight), profile)
    assert (arrival - zenith) * 3600 == pytest.approx(2.726e-4 * 206265, rel=2e-3)


def test_ray_upwards_keeps_its_angle_at_the_target(profile):
    assert surface_zenith_deg(path(0.0, 100.0, 60.0), profile) == pytest.approx((0.0, 60.0))
    target, zenith = surface_zenith_deg(path(6.0, 100.0, 84.4), profile)
    # 84.4 deg at 6 km belongs to 85 deg at the sea.
    assert (target, zenith) == pytest.approx((6000.0, 85.0), abs=0.1)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"geometry": None, "source": "a.csv"}, "a.csv: the file does not give its line of sight"),
        ({"geometry": PathGeometry(2e3, 1e4, 30.0, horizontal=True)}, r"line 12\): the path is horizontal"),
        ({"geometry": PathGeometry(0.0, 10e3, 30.0)}, r"ends at 10 km .* must reach space"),
        ({"geometry": PathGeometry(2e3, 100e3, 90.9)}, "tangent point"),
        ({"geometry": PathGeometry(100e3, 6e3, 99.9)}, "does not meet the surface"),
    ],
)
def test_paths_that_do_not_join_target_and_space_are_refused(profile, changed, message):
    with pytest.raises(CatalogError, match=message):
        combine([path(**changed)], profile)


def test_rectangular_grid_becomes_a_table_that_survives_the_file(profile, tmp_path):
    runs = grid()
    table = combine(runs[::-1], profile).table
    assert table.transmittance.shape == (3, 3, WAVENUMBER.size)
    np.testing.assert_array_equal(table.transmittance[2, 1], runs[7].transmittance)
    table.write(tmp_path / "t.nc", {"title": "a table"})
    again = AtmosphereTable.read(tmp_path / "t.nc")
    np.testing.assert_allclose(again.transmittance, table.transmittance, rtol=1e-7)
    np.testing.assert_allclose(again.path_radiance, table.path_radiance, rtol=1e-7)
    np.testing.assert_array_equal(again.zenith_deg, table.zenith_deg)
    assert again.interpolation_error is None
    assert list(tmp_path.iterdir()) == [tmp_path / "t.nc"]


def test_missing_combinations_are_listed(profile):
    runs = grid()
    del runs[4], runs[0]
    with pytest.raises(CatalogError, match=r"2 of 9 .* missing: 0 km at 0 deg; 1 km at 30.\d+ deg"):
        combine(runs, profile)


def test_equal_local_angles_at_different_heights_are_not_one_zenith_angle(profile):
    up = [path(height, 100.0, 70.0, path_radiance=None) for height in (0.0, 6.0)]
    with pytest.raises(CatalogError, match=r"sin\(zenith\) R / \(R \+ height\)"):
        combine(up, profile)


def test_transmittance_run_and_radiance_run_complete_each_other(profile):
    up = path(0.0, 100.0, 30.0, path_radiance=None)
    down = path(angle_deg=180.0 - np.degrees(np.arcsin(np.sin(np.radians(30.0)) / (1 + 1e5 / EARTH_RADIUS_M))))
    down = SpectralPath(**{**vars(down), "transmittance": None})
    table = combine([up, down], profile).table
    np.testing.assert_array_equal(table.transmittance[0, 0], up.transmittance)
    np.testing.assert_array_equal(table.path_radiance[0, 0], down.path_radiance)


def test_glow_of_the_sky_is_not_taken_for_that_seen_from_space(profile):
    with pytest.raises(CatalogError, match="no run gives the thermal path radiance seen from space"):
        combine([path(0.0, 100.0, 0.0)], profile)


@pytest.mark.parametrize(
    ("runs", "message"),
    [
        ([path(), path()], "given twice"),
        ([path(depth=0.5), path(0.0, 100.0, 0.0, depth=0.6)], "transmittances differ by up to 0.0"),
        ([path(end_km=0, depth=0.2), path(end_km=3, depth=0.5)], "falls with target height"),
        ([path(angle_deg=180, depth=0.5), path(angle_deg=150, depth=0.3)], "rises with zenith angle"),
        ([path(temperature_K=320.0)], "wrong unit or wrong profile"),
        ([path(wavenumber_cm1=WAVENUMBER + 1), path(end_km=1.0)], "different wavenumbers"),
        ([path(resolution_cm1=1.0), path(end_km=1.0, depth=0.1, resolution_cm1=2.0)], "different resolutions: 1, 2"),
        ([path(transmittance=None)], "no run gives the transmittance"),
        ([], "no runs"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(profile, runs, message):
    with pytest.raises(CatalogError, match=message):
        combine(runs, profile)


# --- the door to all readers --------------------------------------------------------------------------------


def test_formats_are_recognised_by_their_content(tmp_path):
    assert detect_format(write(tmp_path / "run", radiance_run(WAVENUMBER))) == "modtran-tape7"
    (tmp_path / "x").write_text('{"MODTRAN": []}')
    assert detect_format(tmp_path / "x") == "modtran6-json"
    (tmp_path / "x.csv").write_text("a,b")
    assert detect_format(tmp_path / "x.csv") == "modtran6-csv"
    (tmp_path / "y.out").write_text("1 2 3")
    with pytest.raises(CatalogError, match=r"not recognised; name it with --format"):
        detect_format(tmp_path / "y.out")
    (tmp_path / "y.inp").write_text("source solar")
    assert detect_format(tmp_path / "y.out") == "libradtran"
    (tmp_path / "t.nc").write_bytes(b"\x89HDF\r\n")
    with pytest.raises(CatalogError, match="needs no import"):
        detect_format(tmp_path / "t.nc")


def test_given_geometry_holds_over_the_header(tmp_path):
    file = write(tmp_path / "a.tp7", transmittance_run(WAVENUMBER, air(WAVENUMBER)[0]))
    sights = dict([parse_geometry("a.tp7=0,100,45"), parse_geometry("100,0,180")])
    (found,) = read_paths(file, ReadOptions(geometry=sights))
    assert found.geometry == PathGeometry(0.0, 100e3, 45.0)
    assert sights["*"] == PathGeometry(100e3, 0.0, 180.0)
    with pytest.raises(ValueError, match=r"expected \[FILE=\]H1_km"):
        parse_geometry("a.tp7=0,100")


def test_unknown_format_is_named_with_the_choices(tmp_path):
    with pytest.raises(CatalogError, match="closest is 'modtran-tape7'"):
        read_paths(tmp_path / "a", ReadOptions(format="modtran-tape"))
