"""Tables of one to three heights or angles."""

import dataclasses

import numpy as np
import pytest
from part_of_table import ROWS, WAVENUMBER, WHOLE, stored, table_provider
from scipy.interpolate import PchipInterpolator

from hcss_twin.core.errors import ProviderError
from hcss_twin.physics.monotone_cubic import pchip_in_window, window_start
from hcss_twin.physics.paths import to_space


def thinned(folder, heights, angles):
    """Write a table with some of the shipped one's nodes."""
    at = np.ix_(
        np.searchsorted(WHOLE.target_altitude_m, heights),
        np.searchsorted(WHOLE.zenith_deg, angles),
        np.arange(WHOLE.wavenumber_cm1.size)[ROWS],
    )
    table = dataclasses.replace(
        WHOLE,
        target_altitude_m=np.array(heights, dtype=float),
        zenith_deg=np.array(angles, dtype=float),
        wavenumber_cm1=WAVENUMBER,
        transmittance=WHOLE.transmittance[at],
        path_radiance=WHOLE.path_radiance[at],
    )
    table.write(folder / "t.nc", {})
    return table_provider(folder / "t.nc")


def test_one_height_and_one_angle_give_exactly_that_path(tmp_path):
    table = thinned(tmp_path, [1000.0], [40.0])
    tau, radiance = stored(1000.0, 40.0)
    path = [to_space(1000.0, 40.0)]
    np.testing.assert_allclose(table.transmittance(WAVENUMBER, path)[0], tau, atol=2e-7)
    np.testing.assert_allclose(table.path_radiance(WAVENUMBER, path)[0], radiance, rtol=1e-4, atol=1e-9)
    assert table.declares.valid["view_zenith"] == (40.0, 40.0)
    assert table.declares.valid["target_altitude_m"] == (1000.0, 1000.0)


@pytest.mark.parametrize(
    ("height", "angle", "message"),
    [
        (1000.0, 39.9, r"allowed 1.3 alone \(zenith 40 deg, the table's only angle\)"),
        (1000.0, 40.1, "allowed 1.3 alone"),
        (999.0, 40.0, "allowed 1000 m alone"),
        (1001.0, 40.0, "allowed 1000 m alone"),
    ],
)
def test_one_node_is_used_nowhere_else(tmp_path, height, angle, message):
    table = thinned(tmp_path, [1000.0], [40.0])
    with pytest.raises(ProviderError, match=message):
        table.transmittance(WAVENUMBER, [to_space(height, angle)])


def test_few_nodes_are_used_inside_their_range_only(tmp_path):
    table = thinned(tmp_path, [500.0, 2000.0, 5000.0], [20.0, 50.0])
    assert np.all(np.isfinite(table.transmittance(WAVENUMBER, [to_space(1500.0, 35.0)])))
    for height, angle in ((400.0, 30.0), (5100.0, 30.0), (1000.0, 10.0), (1000.0, 60.0)):
        with pytest.raises(ProviderError, match="allowed"):
            table.transmittance(WAVENUMBER, [to_space(height, angle)])


@pytest.mark.parametrize("angles", [[20.0, 50.0], [0.0, 30.0, 60.0]])
@pytest.mark.parametrize("heights", [[0.0], [0.0, 1000.0], [0.0, 1000.0, 3000.0]])
def test_nodes_are_met_and_values_between_them_are_between(tmp_path, heights, angles):
    table = thinned(tmp_path, heights, angles)
    for height in heights:
        for angle in angles:
            found = table.transmittance(WAVENUMBER, [to_space(height, angle)])[0]
            np.testing.assert_allclose(found, stored(height, angle)[0], atol=2e-7)
    middle = table.transmittance(WAVENUMBER, [to_space(heights[0], 0.5 * (angles[0] + angles[1]))])[0]
    assert np.all(middle <= stored(heights[0], angles[0])[0] + 2e-7)
    assert np.all(middle >= stored(heights[0], angles[1])[0] - 2e-7)


def test_who_has_few_nodes_says_that_nobody_knows_the_error(tmp_path):
    notes = thinned(tmp_path, [0.0, 1000.0], [0.0]).declares.notes
    assert any("unverified: 2 heights (linear between them), 1 zenith angles (that one only)" in note for note in notes)
    shipped = table_provider("us-standard-1976-lowtran7")
    assert not any("unverified" in note for note in shipped.declares.notes)


@pytest.mark.parametrize("count", [2, 3])
def test_cubic_of_few_nodes_is_scipys(count):
    generator = np.random.default_rng(count)
    nodes, values = np.sort(generator.random(count)), generator.normal(size=(count, 5))
    x = nodes[0] + (nodes[-1] - nodes[0]) * np.concatenate(([0.0, 1.0], generator.random(100)))
    around = window_start(nodes, x)[:, None] + np.arange(count)
    expected = PchipInterpolator(nodes, values)(x)
    np.testing.assert_allclose(pchip_in_window(nodes[around], values[around], x), expected, atol=1e-12)


def test_single_node_is_its_value():
    x = np.array([0.3, 0.3])
    found = pchip_in_window(np.full((2, 1), 0.3), np.array([[[5.0]], [[7.0]]]), x)
    np.testing.assert_array_equal(found, [[5.0], [7.0]])
