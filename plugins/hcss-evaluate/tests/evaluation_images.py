"""Images, cubes and the command for tests of ``hcss evaluate``."""

from __future__ import annotations

import numpy as np
from click.testing import CliRunner
from hcss_evaluate.commands.evaluate import evaluate_command
from random_fields import power_law

from hcss_twin.cli.main import cli

FOUR = ("EV", "Den, printed", "Den", "DP, printed", "DP", "FD")


def hcss(name, *arguments, catch=False):
    words = [str(argument) for argument in arguments]
    command = (evaluate_command, words) if name == "evaluate" else (cli, [name, *words])
    return CliRunner().invoke(*command, catch_exceptions=catch)


def surface(seed, hurst, size):
    """A rough surface whose fractal dimension is 3 less ``hurst``, cut out of a larger periodic one."""
    return power_law(np.random.default_rng(seed), -2.0 - 2.0 * hurst, 2 * size)[:size, :size]


def clouds(seed, hurst=0.6, size=128):
    """Grey levels of a fractal cloud field: half clear."""
    heights = surface(seed, hurst, size)
    return np.clip(heights - np.median(heights), 0.0, None)


def made(path):
    """Three frames in two bands with temperatures and masks."""
    options = {
        "radiance.model": "as-printed", "sea.model": "cox-munk", "optics.provider": "mie",
        "image.rows": 64, "image.columns": 80, "image.pixel_size": 100, "frames.count": 3, "frames.interval": 60,
        "bands": '["mwir","lwir-10.8"]', "clouds.coverage": 0.4, "motion.platform_speed": 0, "output.certificate": 0,
        "output.variables": '["radiance","brightness_temperature","cloud_mask"]',
    }  # fmt: skip
    words = [word for key, value in options.items() for word in ("--set", f"{key}={value}")]
    done = hcss("run", "cumulus", *words, "-o", path)
    assert done.exit_code == 0, done.output
    return path
