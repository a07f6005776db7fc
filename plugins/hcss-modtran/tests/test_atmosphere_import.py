"""hcss atmosphere import: files of another code become a table that `hcss run` uses."""

import numpy as np
import pytest
from command import hcss

from hcss_twin import Scenario, simulate
from hcss_twin.core.catalog import catalog_root
from hcss_twin.core.errors import CatalogError
from hcss_twin.models.atmosphere.table_file import AtmosphereTable
from hcss_twin.plan.make_plan import make_plan

SHIPPED = AtmosphereTable.read(catalog_root() / "atmospheres" / "us-standard-1976-lowtran7.nc")
HEIGHTS = [0.0, 500.0, 1000.0, 1500.0, 2000.0, 3000.0]
ANGLES = [0.0, 20.0, 40.0, 60.0, 75.0]
CHEAP = {"radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie"}
NAMES = "FREQ TOT_TRANS PTH_THRML SURF_EMIS TOTAL_RAD"


def tape7(height_m, zenith_deg, rows=slice(None)):
    """A run of tape7 in few columns, observer at the target looking up and at 100 km looking down."""
    at = list(SHIPPED.target_altitude_m).index(height_m), list(SHIPPED.zenith_deg).index(zenith_deg)
    tau, path = SHIPPED.transmittance[at][rows], SHIPPED.path_radiance[at][rows] * 1e-4
    head = ["T F 6    2    1    0    6    6    6    6    6    6    1    0    0   0.000   0.00", *["card"] * 9]
    lines = [
        f"{v:.2f} {t:.8f} {p:.4E} {0:.4E} {p:.4E}"
        for v, t, p in zip(SHIPPED.wavenumber_cm1[rows], tau, path, strict=True)
    ]
    return "\n".join([*head, NAMES, *lines, " -9999.", ""])


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    files, sights = [], []
    for height in HEIGHTS:
        for angle in ANGLES:
            file = folder / f"h{height:.0f}-z{angle:.0f}.tp7"
            file.write_text(tape7(height, angle))
            # Straight down from 100 km; the table's own angle to 0.02 deg up to 60 deg.
            sine = np.sin(np.radians(angle)) * 6371.23 / 6471.23
            sights += ["--geometry", f"{file.name}=100,{height / 1e3},{180 - np.degrees(np.arcsin(sine))}"]
            files.append(file)
    output = folder / "modtran.nc"
    result = hcss("atmosphere", "import", *files, "-o", output, "--resolution", 20, *sights)
    assert result.exit_code == 0, result.output
    return output, result.output, files


def test_import_says_what_it_read_and_checked(table):
    output, said, _ = table
    assert "h500-z40.tp7 run 1: MODTRAN tape7, IEMSCT 1, 100 km -> 0.5 km" in said
    assert "30 runs: 6 heights (0, 0.5, 1, 1.5, 2, 3 km) x 5 zenith angles" in said
    assert "transmittance never rises with zenith angle" in said
    assert "path radiance never above (1 - T) B(288.2 K)" in said
    assert AtmosphereTable.read(output).resolution_cm1 == 20.0


def test_import_lists_what_is_missing_and_writes_nothing(table, tmp_path):
    _, _, files = table
    with pytest.raises(CatalogError, match="geometry"):
        hcss("atmosphere", "import", files[0], "-o", tmp_path / "a.nc")
    arguments = []
    for at in (0, 1, 5):
        height, angle = HEIGHTS[at // 5] / 1e3, 180 - ANGLES[at % 5]
        arguments += ["--geometry", f"{files[at].name}=100,{height},{angle}"]
    with pytest.raises(CatalogError, match=r"1 of 4 .*missing: 0.5 km at 20.3"):
        hcss("atmosphere", "import", files[0], files[1], files[5], "-o", tmp_path / "a.nc", *arguments)
    assert not list(tmp_path.iterdir())


def test_import_refuses_to_overwrite_and_bad_options(table):
    output, _, files = table
    assert "exists" in hcss("atmosphere", "import", files[0], "-o", output).output
    assert "expected [FILE=]H1_km" in hcss("atmosphere", "import", files[0], "-o", "x.nc", "--geometry", "1,2").output


def test_simulation_with_an_imported_table_agrees_with_the_table_it_was_made_from(table):
    output, _, _ = table
    small = {
        "image.rows": 24,
        "image.columns": 32,
        "frames.count": 1,
        "view.zenith": 20,
        "clouds.base": 800.0,
        "atmosphere.provider": "table",
        **CHEAP,
    }
    mine = {**small, "atmosphere.parameters": {"file": str(output)}}
    found, expected = (simulate(Scenario.load("stratus", changes)).radiance for changes in (mine, small))
    np.testing.assert_allclose(found, expected, rtol=2e-3)
    assert any("unverified" in note for note in make_plan(Scenario.load("stratus", mine)).assembly.notes())
