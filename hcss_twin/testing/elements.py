"""Contract tests of element providers."""

from __future__ import annotations

import numpy as np
import pytest

from hcss_twin.providers import Array, ElementInputs, ElementPixels, ElementProvider, SightPath, Sun
from hcss_twin.providers.common import FRACTION_TOLERANCE, check_element_variables
from hcss_twin.testing.contract import ProviderContract
from hcss_twin.testing.samples import frozen, sample_element_inputs

Pixel = dict[tuple[int, int], list[tuple[float, ...]]]


class PlainScene:
    """A scene of grey air without clouds, for element providers: an ``ElementScene``."""

    def __init__(self, inputs: ElementInputs, sun: Sun | None = None, seed: int = 1) -> None:
        self._inputs = inputs
        self.sun, self.random = sun, np.random.default_rng(seed)

    def project(self, x_m: Array, y_m: Array, altitude_m: Array) -> tuple[Array, Array]:
        """Return row and column of points, without parallax and motion."""
        grid = self._inputs.grid
        return y_m / grid.pixel_size_m + 0.5 * grid.rows, x_m / grid.pixel_size_m + 0.5 * grid.columns

    def path(self, x_m: float, y_m: float, altitude_m: float) -> SightPath:
        """Return air whose optical depth of 0.3 falls off over 8 km."""
        transmittance = np.full(len(self._inputs.bands), np.exp(-0.3 * np.exp(-altitude_m / 8e3)))
        emission = (1.0 - transmittance) * self._inputs.black_body(260.0)
        return SightPath(transmittance, emission, np.ones_like(transmittance))


class ElementContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls; the element appears in the image at the first.
    """

    times_s: tuple[float, ...] = (0.0, 2.0, 7.5)

    def make_provider(self, inputs: ElementInputs) -> ElementProvider:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> ElementInputs:
        """Inputs; override to choose others."""
        return sample_element_inputs()

    def test_declaration_is_sound(self, provider: ElementProvider) -> None:
        """Names, ranges and variables that the engine understands."""
        super().test_declaration_is_sound(provider)
        check_element_variables(provider.variables)

    def test_shapes_ranges_and_what_was_promised(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """Distinct pixels of the window, shares up to 1, either radiance or intensity, declared variables."""
        found = 0
        for part in (part for time in self.times_s for part in _whole(provider, inputs, time)):
            found += part.rows.size
            assert part.rows.dtype.kind == part.columns.dtype.kind == "i"
            assert part.rows.shape == part.columns.shape == part.share.shape == (part.rows.size,)
            assert np.all((part.rows >= 0) & (part.rows < inputs.grid.rows))
            assert np.all((part.columns >= 0) & (part.columns < inputs.grid.columns))
            assert len(set(zip(part.rows.tolist(), part.columns.tolist(), strict=True))) == part.rows.size
            assert np.all((part.share > 0.0) & (part.share <= 1.0 + FRACTION_TOLERANCE))
            assert part.altitude_m >= 0.0
            assert (part.radiance is None) != (part.intensity is None)
            given = part.intensity if part.radiance is None else part.radiance
            assert given is not None
            assert given.shape[-1:] == (len(inputs.bands),)
            assert np.all(np.isfinite(given) & (given >= 0.0))
            assert part.intensity is None or np.sum(part.share) <= 1.0 + FRACTION_TOLERANCE
            assert set(part.truth) == set(provider.variables)
        assert found, "nothing appears in the image at times_s: choose parameters or times at which something does"

    def test_a_window_has_the_pixels_of_the_image(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """Windows, and rows outside the image, change no bit of a pixel."""
        rows, columns = inputs.grid.rows, inputs.grid.columns
        cuts = (slice(-3, 7), slice(7, 8), slice(8, rows)), (slice(0, columns // 2), slice(columns // 2, columns + 2))
        for time in self.times_s:
            whole, pieces = _pixels(_whole(provider, inputs, time)), Pixel()
            for window in ((each, other) for each in cuts[0] for other in cuts[1]):
                pieces |= _pixels(list(provider.pixels(time, *window, PlainScene(inputs))))
            inside = {at: each for at, each in pieces.items() if 0 <= at[0] < rows and 0 <= at[1] < columns}
            assert inside == whole

    def test_times_may_come_in_any_order(self, provider: ElementProvider, inputs: ElementInputs) -> None:
        """Results depend on time and seed alone, not on earlier calls."""
        forward = [_pixels(_whole(provider, inputs, time)) for time in self.times_s]
        other = self.make_provider(inputs)
        backward = [_pixels(_whole(other, inputs, time)) for time in reversed(self.times_s)]
        assert forward == backward[::-1]

    def test_a_band_alone_is_as_among_others(self, inputs: ElementInputs) -> None:
        """Intensity and radiance follow the number of bands."""
        alone = sample_element_inputs(bands=1)
        for part in _whole(self.make_provider(alone), alone, self.times_s[0]):
            given = part.intensity if part.radiance is None else part.radiance
            assert given is not None
            assert given.shape[-1] == 1


def _whole(provider: ElementProvider, inputs: ElementInputs, time_s: float) -> list[ElementPixels]:
    window = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
    return list(provider.pixels(time_s, *window, PlainScene(inputs)))


def _pixels(parts: list[ElementPixels]) -> Pixel:
    """Return the values of each pixel, part by part."""
    found: Pixel = {}
    for part in parts:
        given = frozen(part.intensity if part.radiance is None else part.radiance)
        values = np.broadcast_to(given, (part.rows.size, given.shape[-1]))
        for n, at in enumerate(zip(part.rows.tolist(), part.columns.tolist(), strict=True)):
            own = (part.altitude_m, float(part.share[n]), *values[n].tolist())
            found.setdefault(at, []).append((*own, *(float(each[n]) for each in part.truth.values())))
    return found
