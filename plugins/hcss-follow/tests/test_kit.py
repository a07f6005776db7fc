"""The conformance kit: what every cloud generator must do."""

from dataclasses import replace

import pytest
from conftest import Emitting, images, state_of
from hcss_author import CloudGeneratorContract, sample_cloud_inputs
from hcss_follow.generator import FollowedClouds
from hcss_follow.parameters import FollowedParameters


class TestFollowed(CloudGeneratorContract):
    """A member of the ensemble, so that it changes in all ways."""

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def _state_file(cls, tmp_path_factory):
        cls.path = tmp_path_factory.mktemp("state") / "state.nc"
        state_of(images()).write(cls.path)

    def make_inputs(self, coverage=0.5, seed=1):
        inputs = sample_cloud_inputs(coverage, seed)
        layer = replace(inputs.layer, base_m=500.0, top_m=1500.0, thickness_min_m=1.0)
        return replace(inputs, inversion=Emitting(), layer=layer)

    def make_provider(self, inputs):
        return FollowedClouds(inputs, FollowedParameters(state=str(self.path), member=1))
