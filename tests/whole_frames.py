"""Whole frames of a scene, and of a cloud generator."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.engine.compile import tables_of
from hcss_twin.engine.stream import stream
from hcss_twin.plan.plan import Plan
from hcss_twin.providers import CloudGenerator


def first_frame(plan: Plan) -> dict[str, NDArray[Any]]:
    """Return the variables of the first frame of a scene."""
    return next(stream(plan, tables_of(plan)))


def thickness_frame(clouds: CloudGenerator, time_s: float = 0.0) -> NDArray[np.float32]:
    """Return the thickness (y, x) of all pixels of an image."""
    return clouds.thickness_m(time_s, slice(None), slice(None))
