"""Small distributions: the models of the HCSS paper, which compile in a tenth of a second."""

import copy
import math

import numpy as np
from cheap import CHEAP
from scipy.special import ndtr

SIGMA = 0.7
NEDT_K = 0.05
BANDS = [{"name": "mwir", "limits": [3.6, 3.8]}, {"name": "lwir", "limits": [10.5, 11.0]}]


def nested(dotted):
    """Return tables from dotted keys."""
    found = {}
    for key, value in dotted.items():
        *path, name = key.split(".")
        table = found
        for part in path:
            table = table.setdefault(part, {})
        table[name] = value
    return found


BASE = {
    "time": "2024-04-20T23:30:00+10:00",
    "place": {"latitude": 35.0, "longitude": 150.0},
    "image": {"rows": 48, "columns": 40, "pixel_size": 20.0},
    "frames": {"count": 2, "interval": 0.5},
    "bands": BANDS,
    "clouds": {"type": "stratus", "coverage": 0.5, "coverage_mode": "field"},
    "atmosphere": {"water_vapour_texture": 0.0},
    "sensor": {"parameters": {"psf": "gaussian", "psf_sigma": SIGMA, "noise": "nedt", "nedt": NEDT_K}},
    "slant": {"shadows": "off", "parallax": "off"},
    "sea": {"temperature_texture": 0.0, "model": "cox-munk"},
    "radiance": {"model": "as-printed"},
    "optics": {"provider": "mie"},
}
assert nested(CHEAP).keys() <= BASE.keys()

TARGETS = {
    "count": {"distribution": "poisson", "mu": 2.0},
    "altitude": {"distribution": "uniform", "from": 3000.0, "to": 9000.0},
    "speed": {"distribution": "uniform", "from": 20.0, "to": 60.0},
    "strength": {"scr": {"distribution": "log-uniform", "from": 2.0, "to": 20.0}},
}


def keys(base=None, **sections):
    """Return the keys of a distribution; ``base`` has dotted keys of the scenario that differ."""
    given = {"seed": 3, "base": copy.deepcopy(BASE), "targets": copy.deepcopy(TARGETS), "shards": {"frames": 8}}
    for key, value in (base or {}).items():
        *path, name = key.split(".")
        table = given["base"]
        for part in path:
            table = table.setdefault(part, {})
        if value is None:
            del table[name]
        else:
            table[name] = value
    return given | sections


CLEAR = {"clouds": None}
NOISELESS = {"sensor.parameters": {"psf": "gaussian", "psf_sigma": SIGMA}}


def spot(shape, row, column, motion=(0.0, 0.0), sigma=SIGMA):
    """Image (y, x) of a point of unit energy: a Gaussian averaged over pixels and over a straight motion."""
    steps = 1 if not any(motion) else 8 * math.ceil(math.hypot(*motion)) + 3
    along = (np.arange(steps) + 0.5) / steps - 0.5

    def along_axis(size, at):
        return np.diff(ndtr((np.arange(size + 1) - at) / sigma))

    images = [
        np.outer(along_axis(shape[0], row + s * motion[0]), along_axis(shape[1], column + s * motion[1])) for s in along
    ]
    return np.mean(images, axis=0)


def centre(image):
    """Row and column of the light of an image (y, x); pixel n extends from n to n + 1."""
    y, x = np.indices(image.shape) + 0.5
    return np.sum(image * y) / image.sum(), np.sum(image * x) / image.sum()
