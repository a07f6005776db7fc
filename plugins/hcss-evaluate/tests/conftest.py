"""What is evaluated; computed results are kept apart from the user's cache."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from evaluation_images import made

sys.path.append(str(Path(__file__).parents[3] / "tests"))  # what the tests of several packages share

from hcss_author.own_cache import own_cache  # noqa: F401


@pytest.fixture
def save(tmp_path):
    def save(name, values):
        np.save(tmp_path / name, values)
        return tmp_path / name

    return save


@pytest.fixture(scope="session")
def cube(tmp_path_factory):
    return made(tmp_path_factory.mktemp("cube") / "cube.nc")


@pytest.fixture(scope="session")
def seviri():
    sample = pytest.importorskip("iris_sample_data")
    return Path(sample.path) / "toa_brightness_stereographic.nc"
