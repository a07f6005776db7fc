"""The scene that a provider is made for: when and where it is, its sun, and a logger."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Any

from hcss_twin.providers.column_states import Sun

LOGGER = "hcss_twin.providers"
"""Logger of which those of all providers are children; ``hcss`` prints its warnings to stderr."""


@dataclass(frozen=True)
class SceneInfo:
    """Date, place and sun of a scene, and a logger: for any provider whose class has the parameter ``scene``.

    ``Class(inputs, parameters, scene=...)`` is called with it. Kept results of such a provider are those of one date,
    place and platform speed, so take it only if results depend on it, or to log.

    Attributes
    ----------
    time : datetime
        Start of the scene, ``time_s`` = 0, in UTC.
    latitude_deg, longitude_deg : float
        Image centre at the start.
    sun_at : callable
        ``sun_at(time_s)`` returns the sun seen from the image centre, below the horizon at night.
    log : logging.Logger
        Of the provider. ``hcss`` prints warnings and errors to stderr.
    """

    time: datetime
    latitude_deg: float
    longitude_deg: float
    sun_at: Callable[[float], Sun]
    log: logging.Logger


@cache
def takes_scene(factory: Any) -> bool:
    """Whether the class of a provider has the parameter ``scene``."""
    try:
        return "scene" in inspect.signature(factory).parameters
    except (TypeError, ValueError):  # a class without a signature, written in another language
        return False


def logger_of(kind: str, name: str) -> logging.Logger:
    """Return the logger of a provider."""
    return logging.getLogger(f"{LOGGER}.{kind}.{name}")
