"""Sequences of images for the benchmarks: variables (block, y, x) or (y, x) of one NetCDF file, one for each time."""

import argparse
from datetime import UTC, datetime, timedelta

import numpy as np
from hcss_follow.analysis import Image, analyse

from hcss_twin.providers import NetcdfFile

MARGIN = 64
"""Pixels around what is scored, from where clouds come."""

EDGES_K = 2.0, 20.0
"""How far below the clear sky the mean forecast is where it is thin, and where it is cold."""

START = datetime(2000, 1, 1, tzinfo=UTC)


def parser(description):
    """Return the parser of the arguments that all benchmarks share."""
    made = argparse.ArgumentParser(description=description)
    made.add_argument("file", help="NetCDF file of brightness temperature near 10.8 um, K; first row north")
    made.add_argument("--variables", nargs="+", required=True, help="of each time, in order")
    made.add_argument("--minutes", nargs="+", type=float, required=True, help="times of the variables")
    made.add_argument("--blocks", nargs="+", type=int, help="of the first dimension; default: all")
    made.add_argument("--pixel-size", type=float, default=3000.0, metavar="M")
    return made


def blocks(arguments):
    """Yield number and images {minute: array}, rows northward, of each block; NaN where missing."""
    with NetcdfFile(arguments.file) as file:
        stacks = [file[name] for name in arguments.variables]
        several = len(stacks[0].shape) == 3
        numbers = arguments.blocks or range(stacks[0].shape[0] if several else 1)
        for number in numbers:
            planes = [np.ma.filled(stack[number] if several else stack[:], np.nan) for stack in stacks]
            flipped = [np.asarray(plane, np.float32)[::-1] for plane in planes]
            yield number, dict(zip(arguments.minutes, flipped, strict=True))


def state_of(images, minutes, pixel_size_m):
    """Return the state after the images of some minutes."""
    given = [Image(images[minute], START + timedelta(minutes=minute)) for minute in minutes]
    return analyse(given, pixel_size_m=pixel_size_m, latitude=0.0, longitude=0.0)


def inside(array):
    """Return an array without the margin of its last two axes."""
    return array[..., MARGIN:-MARGIN, MARGIN:-MARGIN]
