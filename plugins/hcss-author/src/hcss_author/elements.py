"""Contract tests of element providers."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from hcss_author.contract import NoMaker, ProviderContract, holds
from hcss_author.samples import sample_element_inputs
from hcss_twin.laws import questions_of
from hcss_twin.laws.samples import PlainScene
from hcss_twin.providers import Array, ElementInputs, ElementPixels, ElementProvider, HcssError, Kind

AROUND = 64
"""Rows and columns around the image that show an element whole."""

ROUNDING = 1e-9
"""Of a sum of shares."""

SHIFT = (3, -2)
"""Rows and columns by which a moved image shows elements elsewhere."""


@dataclass(frozen=True)
class KnownElement:
    """What the author of an element knows of it at one instant, in closed form.

    Attributes
    ----------
    x_m, y_m, altitude_m : float
        Its centre.
    intensity : ndarray (B,)
        Radiant intensity toward the sensor, W sr-1; of a body: radiance times area, as seen from the sensor.
    """

    x_m: float
    y_m: float
    altitude_m: float
    intensity: Array


class _MovedScene(PlainScene):
    """A plain scene whose image shows points elsewhere, by rows and columns, and by rows per metre of altitude."""

    def __init__(self, inputs: ElementInputs, shift: tuple[float, float], rows_per_m: float) -> None:
        super().__init__(inputs)
        self._shift, self._rows_per_m = shift, rows_per_m

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        row, column = super().project(x_m, y_m, altitude_m)
        return row + self._shift[0] + self._rows_per_m * altitude_m, column + self._shift[1]


@holds(Kind.ELEMENTS)
class ElementContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls; the element appears in the image at the first.
    """

    _kind = Kind.ELEMENTS
    times_s: tuple[float, ...] = (0.0, 2.0, 7.5)

    def make_provider(self, inputs: ElementInputs) -> ElementProvider:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    def known(self, inputs: ElementInputs, time_s: float) -> KnownElement | None:
        """Return what a closed form says of the element; override to have position, motion and strength checked."""
        return None

    @pytest.fixture
    def inputs(self) -> ElementInputs:
        """Inputs; override to choose others."""
        return sample_element_inputs()

    @pytest.fixture
    def questions(self, inputs: ElementInputs) -> tuple[Any, ...]:
        """The whole image and a window of it."""
        return questions_of(Kind.ELEMENTS, None, inputs, time_s=self.times_s[0])

    def test_shapes_ranges_and_what_was_promised(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """Distinct pixels of the window, shares up to 1, either radiance or intensity, declared variables."""
        found, guarded = 0, self._guarded(provider, inputs)
        for part in (part for time in self.times_s for part in _whole(guarded, inputs, time)):
            found += part.rows.size
            assert part.intensity is None or np.sum(part.share) <= 1.0 + ROUNDING
        assert found, "nothing appears in the image at times_s: choose parameters or times at which something does"

    def test_a_band_alone_is_as_among_others(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """A band has the same intensity or radiance with and without the others; a provider may need all bands."""
        among = _whole(provider, inputs, self.times_s[0])
        for band, band_inputs in enumerate(inputs.bands):
            body = _one_of(inputs, band)
            alone = dataclasses.replace(inputs, bands=(band_inputs,), black_body=body)
            try:
                found = _whole(self.make_provider(alone), alone, self.times_s[0])
            except HcssError:
                continue
            assert len(found) == len(among)
            for one, other in zip(found, among, strict=True):
                assert _strength(one).shape[-1] == 1
                np.testing.assert_allclose(_strength(one)[..., 0], _strength(other)[..., band], rtol=1e-9)

    def test_an_element_is_where_the_scene_projects_it(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """An image moved by whole pixels shows the same pixels there."""
        for time in self.times_s:
            before, after = (_places(_around(provider, inputs, time, shift=shift)) for shift in ((0.0, 0.0), SHIFT))
            low, high = -AROUND + 4, min(inputs.grid.rows, inputs.grid.columns) + AROUND - 4
            inside = {at for at in before if all(low <= index < high for index in at)}
            assert {(row + SHIFT[0], column + SHIFT[1]) for row, column in inside} <= after

    def test_the_altitude_of_an_element_is_that_of_its_place(
        self, provider: ElementProvider, inputs: ElementInputs
    ) -> None:
        """Parallax in proportion to altitude moves a part by its ``altitude_m``."""
        for time in self.times_s:
            for number, part in enumerate(_around(provider, inputs, time)):
                if part.altitude_m > 0.0:
                    moved = _around(provider, inputs, time, rows_per_m=10.0 / part.altitude_m)[number]
                    assert _centre(moved)[0] - _centre(part)[0] == pytest.approx(10.0, abs=1.0)

    def test_the_shares_of_a_source_sum_to_one(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """All energy of an unresolved source is somewhere on the plane."""
        for time in self.times_s:
            for part in _around(provider, inputs, time):
                if part.intensity is not None and not _reaches_the_end(part, inputs):
                    assert np.sum(part.share) == pytest.approx(1.0, abs=1e-6)

    def test_an_element_keeps_its_place_among_smaller_pixels(self, inputs: ElementInputs) -> None:
        """Pixels of half the size show it at the same distance from the image centre, to a pixel and its extent."""
        grid = inputs.grid
        fine = dataclasses.replace(
            grid, rows=2 * grid.rows, columns=2 * grid.columns, pixel_size_m=grid.pixel_size_m / 2
        )
        finer = dataclasses.replace(inputs, grid=fine)
        one, other = self.make_provider(inputs), self.make_provider(finer)
        for time in self.times_s:
            parts = zip(_whole(one, inputs, time), _whole(other, finer, time), strict=True)
            for coarse, small in parts:
                extent = 1.0 + max(np.ptp(coarse.rows), np.ptp(coarse.columns))
                np.testing.assert_allclose(_centre(small) / 2.0, _centre(coarse), atol=extent)

    def test_place_and_strength_are_those_of_a_closed_form(
        self, provider: ElementProvider, inputs: ElementInputs
    ) -> None:
        """Centroid to half a pixel, altitude and total intensity are what ``known`` says."""
        grid, cosine = inputs.grid, math.cos(math.radians(inputs.view.zenith_deg))
        if self.known(inputs, self.times_s[0]) is None:
            pytest.skip("define known(self, inputs, time_s) to have position, motion and strength checked")
        for time in self.times_s:
            if (known := self.known(inputs, time)) is None:
                assert not _around(provider, inputs, time)
                continue
            parts, area_m2 = _around(provider, inputs, time), grid.pixel_size_m**2 * cosine
            totals = [(1.0 if part.radiance is None else area_m2) * _total(part) for part in parts]
            np.testing.assert_allclose(np.sum(totals, axis=0), known.intensity, rtol=1e-3, err_msg="W/sr")
            weight = np.array([np.sum(part.share) for part in parts])
            places = np.array([[*_centre(part), part.altitude_m] for part in parts])
            row, column, altitude_m = weight @ places / weight.sum()
            expected = known.y_m / grid.pixel_size_m + grid.rows / 2, known.x_m / grid.pixel_size_m + grid.columns / 2
            np.testing.assert_allclose((row, column), expected, atol=0.51, err_msg="row and column")
            assert altitude_m == pytest.approx(known.altitude_m, rel=1e-6, abs=1e-6)


def _whole(provider: ElementProvider, inputs: ElementInputs, time_s: float) -> list[ElementPixels]:
    return PlainScene(inputs).shown(provider, time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))


def _places(parts: list[ElementPixels]) -> set[tuple[int, int]]:
    """Return the pixels of all parts."""
    return {place for part in parts for place in zip(part.rows.tolist(), part.columns.tolist(), strict=True)}


def _around(
    provider: ElementProvider,
    inputs: ElementInputs,
    time_s: float,
    shift: tuple[float, float] = (0.0, 0.0),
    rows_per_m: float = 0.0,
) -> list[ElementPixels]:
    """Return the parts in the image and around it."""
    window = slice(-AROUND, inputs.grid.rows + AROUND), slice(-AROUND, inputs.grid.columns + AROUND)
    return _MovedScene(inputs, shift, rows_per_m).shown(provider, time_s, *window)


def _reaches_the_end(part: ElementPixels, inputs: ElementInputs) -> bool:
    sizes = (part.rows, inputs.grid.rows), (part.columns, inputs.grid.columns)
    return any(indices.min() == -AROUND or indices.max() == size + AROUND - 1 for indices, size in sizes)


def _one_of(inputs: ElementInputs, band: int) -> Callable[[float], Array]:
    return lambda temperature_K: inputs.black_body(temperature_K)[band : band + 1]


def _strength(part: ElementPixels) -> Array:
    given = part.intensity if part.radiance is None else part.radiance
    assert given is not None
    return given


def _total(part: ElementPixels) -> Array:
    """Sum (B,) over the pixels."""
    strengths = np.broadcast_to(_strength(part), (part.rows.size, _strength(part).shape[-1]))
    total: Array = part.share @ strengths
    return total


def _centre(part: ElementPixels) -> Array:
    """Row and column of the centroid."""
    weighted = np.array([part.share @ (part.rows + 0.5), part.share @ (part.columns + 0.5)])
    centre: Array = weighted / np.sum(part.share)
    return centre
