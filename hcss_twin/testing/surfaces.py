"""Contract tests of surface providers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hcss_twin.providers import Array, SurfaceInputs, SurfaceMap, SurfaceProvider
from hcss_twin.providers.common import FRACTION_TOLERANCE, KELVIN_TOLERANCE, check_surface_classes
from hcss_twin.testing.contract import ProviderContract
from hcss_twin.testing.samples import frozen, sample_surface_inputs, sample_wavenumbers

PLAUSIBLE_K = (150.0, 400.0)
"""Temperatures of sea, land and ice in kelvin; another unit is outside."""

_MARGIN = 5
"""Rows and columns beyond the image that are asked for, as a sensor's blur does."""


class SurfaceContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    times_s : tuple of float
        Times of the calls.
    is_still : bool
        Whether the surface is the same at all times.
    """

    times_s: tuple[float, ...] = (0.0, 2.0, 7.5)
    is_still: bool = True

    def make_provider(self, inputs: SurfaceInputs) -> SurfaceProvider:
        """Return the provider under test."""
        raise NotImplementedError("define make_provider(self, inputs)")

    @pytest.fixture
    def inputs(self) -> SurfaceInputs:
        """Inputs; override to choose others."""
        return sample_surface_inputs()

    def test_declaration_is_sound(self, provider: SurfaceProvider) -> None:
        """Names and classes that the engine understands."""
        super().test_declaration_is_sound(provider)
        check_surface_classes(provider.classes)

    def test_classes_have_names_of_the_declaration(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """Numbers of declared classes, for every point of the window."""
        found = set()
        for time in self.times_s:
            number = _whole(provider, inputs, time).number
            assert number.shape == (inputs.grid.rows, inputs.grid.columns)
            assert number.dtype.kind in "iu"
            assert number.min() >= 0
            assert number.max() < len(provider.classes)
            found |= set(np.unique(number).tolist())
        assert found, "the map is empty"

    def test_temperatures_are_kelvin_within_the_limits_of_their_class(
        self, provider: SurfaceProvider, inputs: SurfaceInputs
    ) -> None:
        """Finite where the class has a field of temperature, within its limits, and of a size that means kelvin."""
        for each in provider.classes:
            ends = each.temperature_K if isinstance(each.temperature_K, tuple) else (each.temperature_K,)
            assert all(end is None or PLAUSIBLE_K[0] <= end <= PLAUSIBLE_K[1] for end in ends), each.name
        for time in self.times_s:
            ground = _whole(provider, inputs, time)
            for number, each in enumerate(provider.classes):
                if isinstance(each.temperature_K, tuple):
                    assert ground.temperature_K is not None
                    here = ground.temperature_K[ground.number == number]
                    assert np.all(np.isfinite(here)), each.name
                    low, high = each.temperature_K
                    assert np.all((here >= low - KELVIN_TOLERANCE) & (here <= high + KELVIN_TOLERANCE)), each.name

    def test_a_window_has_the_points_of_the_image(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """Windows, and rows outside the image, change no bit of a point."""
        rows, columns = inputs.grid.rows, inputs.grid.columns
        cuts = (slice(-_MARGIN, 7), slice(7, 8), slice(8, rows + _MARGIN)), (
            slice(-_MARGIN, columns // 2), slice(columns // 2, columns + _MARGIN))  # fmt: skip
        for time in self.times_s:
            pieces = [[_values(provider, inputs, provider.surface(time, y, x)) for x in cuts[1]] for y in cuts[0]]
            together = np.concatenate([np.concatenate(row, axis=-1) for row in pieces], axis=-2)
            inside = together[:, _MARGIN:-_MARGIN, _MARGIN:-_MARGIN]
            np.testing.assert_array_equal(inside, _values(provider, inputs, _whole(provider, inputs, time)))

    def test_times_may_come_in_any_order(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """Results depend on time alone, not on earlier calls."""
        forward = [_values(provider, inputs, _whole(provider, inputs, time)) for time in self.times_s]
        other = self.make_provider(inputs)
        backward = [_values(other, inputs, _whole(other, inputs, time)) for time in reversed(self.times_s)]
        np.testing.assert_array_equal(forward, backward[::-1])

    def test_the_map_moves_with_the_ground(self, provider: SurfaceProvider, inputs: SurfaceInputs) -> None:
        """As the platform moves by whole points, the map moves by as many, unless the surface changes with time."""
        if not self.is_still:
            pytest.skip("the surface changes with time")

        def moving(time_s: float, rows: slice, columns: slice) -> tuple[Array, Array]:
            way = round(3.0 * time_s)
            return inputs.ground(0.0, rows, slice(columns.start + way, columns.stop + way))

        window = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
        beside = window[0], slice(3, inputs.grid.columns + 3)
        one, other = (self.make_provider(each) for each in (inputs, replace(inputs, ground=moving)))
        expected, seen = one.surface(0.0, *beside), other.surface(1.0, *window)
        np.testing.assert_array_equal(seen.number, expected.number)
        if expected.temperature_K is not None and seen.temperature_K is not None:
            np.testing.assert_allclose(seen.temperature_K, expected.temperature_K, atol=1e-3)

    def test_emissivity_and_albedo_of_each_class_sum_to_1(self, provider: SurfaceProvider) -> None:
        """Emissivity plus the integral of BRDF times cosine over the sky is 1 in each direction, within 0.1."""
        x, weight = np.polynomial.legendre.leggauss(32)
        turns = (np.arange(32) + 0.5) * np.pi / 32
        cosine, turn = (each.ravel() for each in np.meshgrid(0.5 * (x + 1.0), turns, indexing="ij"))
        share = np.repeat(0.5 * weight, turns.size) * 2.0 * np.pi * cosine / turns.size
        for each in provider.classes:
            boundary = each.boundary
            if boundary is None:  # the scenario's sea, or a Lambertian surface of the engine
                continue
            wavenumber = sample_wavenumbers(boundary.declares, 5)
            for mu in (1.0, 0.5):
                emissivity = boundary.emissivity(wavenumber, frozen([mu]))[0]
                assert np.all((emissivity >= -FRACTION_TOLERANCE) & (emissivity <= 1.0 + FRACTION_TOLERANCE)), each.name
                brdf = boundary.brdf(wavenumber, frozen(np.full(cosine.size, mu)), frozen(cosine), frozen(turn))
                np.testing.assert_allclose(emissivity + share @ brdf, 1.0, atol=0.1, err_msg=each.name)


def _whole(provider: SurfaceProvider, inputs: SurfaceInputs, time_s: float) -> SurfaceMap:
    return provider.surface(time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))


def _values(provider: SurfaceProvider, inputs: SurfaceInputs, ground: SurfaceMap) -> Array:
    """Return class and temperature (2, y, x), 0 where the class has no field of it."""
    number = ground.number.astype(np.float64)
    fields = [n for n, each in enumerate(provider.classes) if isinstance(each.temperature_K, tuple)]
    kelvin = np.zeros(number.shape)
    if fields and ground.temperature_K is not None:
        kelvin = np.where(np.isin(ground.number, fields), ground.temperature_K, 0.0)
    return np.stack((number, kelvin))
