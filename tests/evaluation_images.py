"""Images, cubes and the command for tests of ``hcss evaluate``."""

from __future__ import annotations

import numpy as np
from cheap import CHEAP_OPTIONS
from click.testing import CliRunner
from fractional_brownian_surface import fractional_brownian_surface

from hcss_twin.cli.main import cli

FOUR = ("EV", "Den, printed", "Den", "DP, printed", "DP", "FD")


def hcss(*arguments, catch=False):
    return CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=catch)


def clouds(seed, hurst=0.6, size=128):
    """Grey levels of a fractal cloud field: half clear."""
    surface = fractional_brownian_surface(size, hurst, seed)
    return np.clip(surface - np.median(surface), 0.0, None)


def made(path):
    """Three frames in two bands with temperatures and masks."""
    options = {
        "image.rows": 64, "image.columns": 80, "image.pixel_size": 100, "frames.count": 3, "frames.interval": 60,
        "bands": '["mwir","lwir-10.8"]', "clouds.coverage": 0.4, "motion.platform_speed": 0, "output.certificate": 0,
        "output.variables": '["radiance","brightness_temperature","cloud_mask"]',
    }  # fmt: skip
    words = [word for key, value in options.items() for word in ("--set", f"{key}={value}")]
    done = hcss("run", "cumulus", *words, *CHEAP_OPTIONS, "-o", path)
    assert done.exit_code == 0, done.output
    return path
