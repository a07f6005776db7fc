"""Contract tests of cloud generators."""

from __future__ import annotations

import dataclasses
import functools
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from unittest import SkipTest

import numpy as np
import pytest
from numpy.typing import NDArray

from hcss_author.contract import NoMaker, ProviderContract, holds
from hcss_author.samples import sample_cloud_inputs
from hcss_twin.laws import laws_of, questions_of
from hcss_twin.providers import CloudGenerator, CloudInputs, Kind

_LAWS = laws_of(Kind.CLOUDS)


@holds(Kind.CLOUDS)
class CloudGeneratorContract(ProviderContract):
    """Inherit in a class named ``Test...`` and define ``make_provider``.

    Attributes
    ----------
    coverage_tolerance : float
        Allowed difference between the cloudy fraction, averaged over ``seeds`` frames with different seeds, and the
        layer's coverage.
    seeds : int
        Number of those frames.
    seed_matters : bool
        Whether fields are drawn at random; False for a generator of given fields.
    """

    _kind = Kind.CLOUDS
    coverage_tolerance: float = 0.1
    seeds: int = 16
    seed_matters: bool = True

    def make_provider(self, inputs: CloudInputs) -> CloudGenerator:
        """Return the provider under test."""
        raise NoMaker("define make_provider(self, inputs)")

    def make_inputs(self, coverage: float = 0.5, seed: int = 1) -> CloudInputs:
        """Return inputs; override for a generator that needs type parameters or another image."""
        return sample_cloud_inputs(coverage, seed)

    @pytest.fixture
    def inputs(self) -> CloudInputs:
        """Inputs of half coverage."""
        return self.make_inputs()

    @pytest.fixture
    def questions(self, provider: CloudGenerator, inputs: CloudInputs) -> tuple[Any, ...]:
        """The whole image and a window of it."""
        return questions_of(Kind.CLOUDS, provider, inputs)

    def frame(self, inputs: CloudInputs, time_s: float = 0.0) -> NDArray[np.float32]:
        """Return a whole frame of a new provider."""
        return _whole(self.make_provider(inputs), inputs, time_s)

    def test_shape_and_type(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """float32 (rows, columns)."""
        field = _whole(provider, inputs)
        assert field.shape == (inputs.grid.rows, inputs.grid.columns)
        assert field.dtype == np.float32

    def test_no_coverage_is_clear_sky_and_full_coverage_has_no_gap(self) -> None:
        """Coverage 0: 0 everywhere. Coverage 1: cloud everywhere. A picture keeps its own coverage."""
        if getattr(self.make_provider(self.make_inputs()), "image_coverage", None) is not None:
            pytest.skip("image_coverage replaces the coverage of the layer")
        assert not np.any(self.frame(self.make_inputs(coverage=0.0)))
        assert np.all(self.frame(self.make_inputs(coverage=1.0)) > 0.0)

    def test_cloudy_fraction_is_the_coverage(self) -> None:
        """The mean over seeds is the layer's coverage, or ``image_coverage`` of a provider that has it."""
        for coverage in (0.3, 0.7):
            providers = [self.make_provider(self.make_inputs(coverage, seed)) for seed in range(self.seeds)]
            declared = getattr(providers[0], "image_coverage", None)
            fields = [_whole(provider, self.make_inputs(coverage)) for provider in providers]
            expected = coverage if declared is None else float(declared)
            found = float(np.mean(np.stack(fields) > 0.0))
            assert found == pytest.approx(expected, abs=self.coverage_tolerance), f"mean of {self.seeds} seeds"

    def test_field_does_not_depend_on_threads(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """Frames computed concurrently by several threads equal those computed one by one."""
        times = [2.0 * index for index in range(6)]
        with ThreadPoolExecutor(max_workers=3) as pool:
            parallel = list(pool.map(lambda time_s: _whole(provider, inputs, time_s), times))
        for time_s, field in zip(times, parallel, strict=True):
            np.testing.assert_array_equal(field, _whole(provider, inputs, time_s))

    def test_a_sky_goes_on_around_the_image(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """Windows that reach outside the image have its pixels inside it, and one value for each pixel outside."""
        if not hasattr(provider, "thickness_around_m"):
            pytest.skip("the generator computes no clouds outside the image")
        summary = None if provider.declares.tileable else provider.frame_summary(4.0)  # type: ignore[attr-defined]
        around = functools.partial(provider.thickness_around_m, summary=summary)
        (rows, columns), (above, right) = (inputs.grid.rows, inputs.grid.columns), (5, 9)
        wide = around(4.0, slice(-3, rows + above), slice(-4, columns + right))
        inside = slice(3, -above), slice(4, -right)
        np.testing.assert_array_equal(wide[inside], _whole(provider, inputs, 4.0))
        assert wide.dtype == np.float32
        part = around(4.0, slice(-2, 6), slice(columns, columns + 2))
        np.testing.assert_array_equal(part, wide[1:9, 4 + columns : 6 + columns])

    def test_cloud_tops_are_within_their_range(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """Altitudes of tops are alike in any window, and clouds hang from them without reaching below the sea."""
        if getattr(provider, "cloud_top_range_m", None) is None:
            pytest.skip("cloud tops are those of the layer")
        whole_image = slice(0, inputs.grid.rows), slice(0, inputs.grid.columns)
        top: NDArray[np.float32] = provider.cloud_top_m(4.0, *whole_image)  # type: ignore[attr-defined]
        low, high = provider.cloud_top_range_m  # type: ignore[attr-defined]
        assert top.dtype == np.float32
        assert np.float32(low) <= top.min() <= top.max() <= np.float32(high)
        assert np.all(_whole(provider, inputs, 4.0) <= top)
        part = provider.cloud_top_m(4.0, slice(5, 31), slice(17, 18))  # type: ignore[attr-defined]
        np.testing.assert_array_equal(part, top[5:31, 17:18])

    def test_clouds_are_spread_over_heights_of_their_layer(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """Heights from the top down are above 0, within the layer, and alike in any window."""
        if getattr(provider, "cloud_top_range_m", None) is None or not hasattr(provider, "cloud_depth_m"):
            pytest.skip("clouds are as high as they are thick")
        depth = provider.cloud_depth_m(4.0, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))
        assert depth.dtype == np.float32
        assert 0.0 < depth.min() <= depth.max() <= np.float32(inputs.layer.thickness_max_m)
        part = provider.cloud_depth_m(4.0, slice(5, 31), slice(17, 18))
        np.testing.assert_array_equal(part, depth[5:31, 17:18])

    def test_shares_of_heights_hold_the_whole_column(self, provider: CloudGenerator, inputs: CloudInputs) -> None:
        """They sum to 1 where there is cloud, and do not depend on the window."""
        if not hasattr(provider, "height_shares"):
            pytest.skip("columns are uniform")
        field, edges = _whole(provider, inputs, 4.0), np.linspace(inputs.layer.base_m, inputs.layer.top_m, 17)
        shares = provider.height_shares(4.0, slice(0, field.shape[0]), slice(0, field.shape[1]), field, edges)
        assert shares.dtype == np.float32
        np.testing.assert_allclose(shares.sum(axis=0), field > 0.0, atol=1e-4)
        assert shares.min() >= 0.0
        part = provider.height_shares(4.0, slice(5, 31), slice(17, 18), field[5:31, 17:18], edges)
        np.testing.assert_array_equal(part, shares[:, 5:31, 17:18])

    def test_seed_matters(self) -> None:
        """Other seeds give other fields, except of a generator with ``image_coverage``, which is given its picture."""
        if not self.seed_matters:
            pytest.skip("the fields are given, not drawn")
        try:
            _LAWS["seed_matters"](self.make_provider, self.make_inputs(0.5, 1))
        except SkipTest as why:
            pytest.skip(str(why))

    def test_thickness_keeps_other_limits(self) -> None:
        """0, or between the limits of a layer that is thinner or has a greater least thickness."""
        inputs = self.make_inputs(0.5, 1)
        for minimum, maximum in ((20.0, 300.0), (200.0, 1500.0)):
            layer = dataclasses.replace(inputs.layer, thickness_min_m=minimum, top_m=inputs.layer.base_m + maximum)
            other = dataclasses.replace(inputs, layer=layer)
            _LAWS["thickness_stays_within_the_layer"](self.make_provider(other), other, (0.0,))


def _whole(provider: CloudGenerator, inputs: CloudInputs, time_s: float = 0.0) -> NDArray[np.float32]:
    return provider.thickness_m(time_s, slice(0, inputs.grid.rows), slice(0, inputs.grid.columns))
