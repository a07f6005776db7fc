"""Errors that a provider states of itself, for ``hcss plugins NAME``."""

from __future__ import annotations

import inspect
from dataclasses import asdict
from itertools import groupby
from typing import Any

_SUNLIGHT = {None: "", True: "with sunlight", False: "without sunlight"}


def stated_errors(provider: type) -> list[dict[str, Any]] | None:
    """Return the fields of each ``ModelError`` of a provider.

    Returns
    -------
    list of dict or None
        Empty if it states none; None if the figures belong to an instance, and so to a scene.
    """
    method = inspect.getattr_static(provider, "model_errors", None)
    if method is None:
        return []
    if not isinstance(method, staticmethod | classmethod):
        return None
    return [asdict(each) | {"zenith_deg": list(each.zenith_deg)} for each in provider.model_errors()]  # type: ignore[attr-defined]


def stated_error_lines(errors: list[dict[str, Any]] | None) -> list[str]:
    """Return stated errors as text: each cause and reference once, then a line for each band, path and column."""
    if errors is None:
        return ["  stated error: depends on the scene, see hcss plan"]
    lines = ["  stated error:"] if errors else []
    for (name, source, condition, command), own in groupby(
        errors, lambda each: tuple(each[key] for key in ("name", "source", "condition", "command"))
    ):
        lines += [
            f"    {name}, against {source}",
            f"      {'; '.join(filter(None, (condition, command or 'from notes')))}",
        ]
        for each in own:
            sizes = [f"{100.0 * each['relative']:.3g} %"] if each["relative"] is not None else []
            sizes += [f"{each['kelvin']:.3g} K"] if each["kelvin"] is not None else []
            low, high = each["zenith_deg"]
            path = "" if each["path"] == "up" else f"path {each['path']}"
            view = "" if (low, high) == (0.0, 90.0) else f"zenith {low:g}-{high:g} deg"
            of = ", ".join(filter(None, (path, each["column"], _SUNLIGHT[each["sunlight"]], view)))
            um = f"{each['lower_um']:.3g}-{each['upper_um']:.3g} um"
            lines.append(f"      {um:<14}{', '.join(sizes):<18}{each['statistic']:<16}{of}".rstrip())
    return lines
