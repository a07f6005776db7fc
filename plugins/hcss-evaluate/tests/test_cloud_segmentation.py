"""Laws of cleaning and labelling a cloud mask."""

from __future__ import annotations

import numpy as np
import pytest
from hcss_evaluate.database.segmentation import Cleaning, closed, disc, opened, segment, small_holes

NOTHING = np.zeros((40, 50), dtype=bool)
PLAIN = Cleaning(closing=1, opening=1, largest_hole=0, min_area=1)


def _noise(seed=0, share=0.45, shape=(40, 50)):
    return np.random.default_rng(seed).random(shape) < share


def _connected(mask, diagonal):
    """Number the parts of a mask by flooding, one pixel after the other."""
    steps = [(-1, 0), (1, 0), (0, -1), (0, 1)] + ([(-1, -1), (-1, 1), (1, -1), (1, 1)] if diagonal else [])
    numbers, count = np.zeros(mask.shape, dtype=int), 0
    for start in np.argwhere(mask):
        if numbers[tuple(start)]:
            continue
        count += 1
        todo = [tuple(start)]
        while todo:
            row, column = todo.pop()
            inside = 0 <= row < mask.shape[0] and 0 <= column < mask.shape[1]
            if inside and mask[row, column] and not numbers[row, column]:
                numbers[row, column] = count
                todo += [(row + dy, column + dx) for dy, dx in steps]
    return numbers, count


@pytest.mark.parametrize("seed", range(4))
def test_labels_partition_the_mask_into_connected_clouds(seed):
    mask = _noise(seed)
    found = segment(mask, NOTHING, PLAIN)
    expected, count = _connected(mask, diagonal=True)
    assert found.clouds == count
    # The same partition, and numbered in the order of first pixels.
    np.testing.assert_array_equal(found.labels, expected)


def test_small_clouds_go_and_the_rest_is_numbered_without_gaps():
    mask = NOTHING.copy()
    mask[2, 2:4] = mask[10:14, 10:14] = mask[20, 20] = mask[30:33, 30:33] = True
    found = segment(mask, NOTHING, Cleaning(1, 1, 0, min_area=9))
    assert (found.clouds, found.dropped) == (2, 2)
    assert set(found.labels[10:14, 10:14].ravel()) == {1}
    assert set(found.labels[30:33, 30:33].ravel()) == {2}
    assert np.count_nonzero(found.labels) == 16 + 9


@pytest.mark.parametrize("largest", [0, 3, 8, 10_000])
@pytest.mark.parametrize("seed", range(3))
def test_holes_are_the_enclosed_parts_of_clear_sky_up_to_a_size(seed, largest):
    mask = _noise(seed, 0.6)
    found = segment(mask, NOTHING, Cleaning(1, 1, largest, 1))
    clear, count = _connected(~mask, diagonal=False)
    expected = mask.copy()
    for number in range(1, count + 1):
        part = clear == number
        touches = part[0].any() or part[-1].any() or part[:, 0].any() or part[:, -1].any()
        if not touches and part.sum() <= largest:
            expected |= part
    np.testing.assert_array_equal(found.labels > 0, expected)
    assert found.hole_pixels == expected.sum() - mask.sum()


def test_a_hole_with_a_missing_pixel_is_not_known_to_be_one():
    mask, missing = NOTHING.copy(), NOTHING.copy()
    mask[5:15, 5:15] = True
    mask[8:10, 8:10] = False
    cleaning = Cleaning(closing=1, opening=1, largest_hole=100, min_area=1)
    assert segment(mask, missing, cleaning).holes == 1
    missing[8, 8] = True
    found = segment(mask, missing, cleaning)
    assert found.holes == 0
    assert not found.labels[8:10, 8:10].any()


def test_missing_pixels_are_never_cloud():
    missing = _noise(5, 0.1)
    found = segment(_noise(6, 0.6), missing, Cleaning(5, 3, 1000, 1))
    assert found.clouds
    assert not found.labels[missing].any()


@pytest.mark.parametrize("diameter", [3, 5, 9])
def test_closing_adds_opening_removes_and_doing_it_again_changes_nothing(diameter):
    mask = _noise(1, 0.5)
    more, less = closed(mask, diameter), opened(mask, diameter)
    assert np.all(more >= mask)
    assert np.all(less <= mask)
    np.testing.assert_array_equal(closed(more, diameter), more)
    np.testing.assert_array_equal(opened(less, diameter), less)


@pytest.mark.parametrize("diameter", [3, 5])
def test_opening_is_the_union_of_the_discs_that_fit(diameter):
    mask = _noise(2, 0.85)
    element, half = disc(diameter), diameter // 2
    # What lies outside counts as cloud.
    wide = np.pad(mask, half, constant_values=True)
    union = np.zeros_like(wide)
    for row, column in np.ndindex(*mask.shape):
        window = slice(row, row + diameter), slice(column, column + diameter)
        if wide[window][element].all():
            union[window] |= element
    np.testing.assert_array_equal(opened(mask, diameter), union[half:-half, half:-half] & mask)


def test_closing_comes_before_opening():
    mask = NOTHING.copy()
    # A chequered block: closing makes it solid, opening alone would remove it.
    mask[10:20, 10:20] = (np.indices((10, 10)).sum(0) % 2) == 0
    mask[30, 30] = True
    found = segment(mask, NOTHING, Cleaning(closing=3, opening=3, largest_hole=0, min_area=1))
    assert found.clouds == 1
    # Its four corners are cut or kept by the chequer's parity.
    assert np.count_nonzero(found.labels[10:20, 10:20]) >= 96
    assert not opened(mask, 3).any()


def test_gaps_narrower_than_the_disc_are_joined_and_wider_ones_stay():
    mask = NOTHING.copy()
    mask[5:15, 5:10] = mask[5:15, 12:17] = mask[5:15, 22:27] = True
    assert segment(mask, NOTHING, Cleaning(1, 1, 0, 1)).clouds == 3
    assert segment(mask, NOTHING, Cleaning(3, 1, 0, 1)).clouds == 2
    assert segment(mask, NOTHING, Cleaning(7, 1, 0, 1)).clouds == 1


def test_nothing_cloudy_gives_no_cloud():
    assert segment(NOTHING, NOTHING).clouds == 0
    assert small_holes(~NOTHING, NOTHING, 10)[1] == 0


@pytest.mark.parametrize(
    ("wrong", "closest"),
    [({"closing": 4}, "5"), ({"opening": 0}, "1"), ({"largest_hole": -1}, "0"), ({"min_area": 0}, "1")],
)
def test_sizes_out_of_range_are_refused(wrong, closest):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))}: .* closest is {closest}"):
        Cleaning(**wrong)
