"""Surrogates in the conformance kit."""

from dataclasses import replace

import numpy as np
import pytest
from hcss_author import CloudGeneratorContract, assert_registered, sample_cloud_inputs
from hcss_skies.surrogate.generator import SurrogateClouds
from hcss_skies.surrogate.parameters import SurrogateParameters
from scipy.ndimage import gaussian_filter

from hcss_twin.providers import Catalog


class TestSurrogate(CloudGeneratorContract):
    coverage_tolerance = 1e-3
    seeds = 2
    mode = "frame"

    @pytest.fixture(autouse=True)
    def _image(self, tmp_path):
        self.folder = tmp_path
        np.save(tmp_path / "image.npy", gaussian_filter(np.random.default_rng(6).random((90, 100)), 2.0))

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = sample_cloud_inputs(coverage, seed, catalog=Catalog(base=self.folder))
        return replace(inputs, layer=replace(inputs.layer, coverage_mode=self.mode))

    def make_provider(self, inputs):
        return SurrogateClouds(inputs, SurrogateParameters(image="image.npy", method="coverage"))


class TestSurrogateOfTheField(TestSurrogate):
    coverage_tolerance = 0.02  # exact over the whole torus, of which the image is a part
    seeds = 16
    mode = "field"


def test_it_is_registered():
    assert_registered("clouds", "surrogate", "hcss-skies")
