"""Labelled infrared data sets with small targets, and their scores.

    >>> from hcss_dataset import Frames
    >>> frame = Frames("my-set", split="train")[0]
    >>> frame.image.shape, frame.labels["targets"]

The names in ``__all__`` are imported on first use: ``hcss --help`` imports this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hcss_dataset.errors import DatasetError
    from hcss_dataset.reader import Frames

__all__ = ["DatasetError", "Frames"]


def __getattr__(name: str) -> Any:
    homes = {"DatasetError": "errors", "Frames": "reader"}
    if name not in homes:
        raise AttributeError(f"module 'hcss_dataset' has no attribute '{name}'")
    return getattr(import_module(f"hcss_dataset.{homes[name]}"), name)
