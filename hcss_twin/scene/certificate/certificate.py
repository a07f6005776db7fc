"""The certificate of a cube: random pixels of it computed again on the reference path.

What is certified is the engine's error against the selected providers evaluated exactly: the providers are asked at
every wavenumber of the dense grid for the very column of each pixel, without tables, interpolation or chosen
wavenumbers. What a provider says about its own error is not part of it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcss_twin.radiance.reference import reference_radiance
from hcss_twin.scene.certificate.certificate_pixels import SampledPixels
from hcss_twin.scene.certificate.confidence import CONFIDENCE, share_drawn_alike, share_of_all
from hcss_twin.scene.certificate.strata import stratum_names
from hcss_twin.scene.plan import Plan
from hcss_twin.scene.tables.radiance_tables import RadianceTables

Array = NDArray[np.float64]

COLUMNS_AT_ONCE = 32
"""Columns for which the model is asked together; its memory grows with them."""

_DIGITS = 3
"""Of errors told: sums of the reference may differ in their last bits between machines."""


@dataclass(frozen=True)
class StratumCheck:
    """What was found in one stratum.

    Attributes
    ----------
    name : str
    pixels : int
        Pixels of the stratum in the checked frames that could have been drawn.
    checked, exceeding : int
        How many were, and how many of these err by more than was asked for in some band.
    error : tuple of float (B,)
        Largest relative error of each band; empty where no pixel was checked.
    left_out : mapping of str to int
        Pixels that the reference cannot follow, by reason.
    """

    name: str
    pixels: int
    checked: int
    exceeding: int
    error: tuple[float, ...]
    left_out: dict[str, int]


@dataclass(frozen=True)
class Certificate:
    """Requested, estimated and achieved error of a cube, relative to the total radiance of the band.

    Attributes
    ----------
    requested, estimated : float
        The scenario's accuracy; what the tables said while they were placed.
    bands : tuple of str (B,)
    strata : tuple of StratumCheck
        Those of which the checked frames have pixels.
    frames : tuple of int
        Checked frames.
    open_share : float
        Greatest share of the checked frames' pixels that can exceed, at 95 % confidence, if no checked one does.
    """

    requested: float
    estimated: float
    bands: tuple[str, ...]
    strata: tuple[StratumCheck, ...]
    frames: tuple[int, ...]
    open_share: float

    @property
    def checked(self) -> int:
        """Number of pixels checked."""
        return sum(stratum.checked for stratum in self.strata)

    @property
    def exceeding(self) -> int:
        """Number of those that err by more than was asked for."""
        return sum(stratum.exceeding for stratum in self.strata)

    @property
    def passed(self) -> bool:
        """Whether no checked pixel errs by more than was asked for."""
        return self.exceeding == 0

    @property
    def achieved(self) -> dict[str, float]:
        """Largest relative error of each band; empty where nothing was checked."""
        errors = [stratum.error for stratum in self.strata if stratum.checked]
        return dict(zip(self.bands, map(max, zip(*errors, strict=True)), strict=True)) if errors else {}

    @property
    def lines(self) -> tuple[str, ...]:
        """The certificate in words, the verdict first."""
        achieved = ", ".join(f"{band} {error:.{_DIGITS}g}" for band, error in self.achieved.items())
        told = ", ".join(
            f"{each.name} {each.checked} of {each.pixels}" for each in self.strata if each.pixels
        )
        return (
            self._verdict,
            f"relative error of the band radiance: requested {self.requested:g}, estimated {self.estimated:.2g}, "
            f"achieved {achieved or 'unknown'}",
            f"checked pixels of frame{'s' if len(self.frames) > 1 else ''} {', '.join(map(str, self.frames))}: "
            f"{told or 'none'}",
            *self._left_out,
            *self._confidence,
            "this is the engine's error against the selected providers evaluated exactly; what these say about their "
            "own error is apart from it",
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for ``hcss run --json``."""
        return {
            "passed": self.passed,
            "requested": self.requested,
            "estimated": self.estimated,
            "achieved": self.achieved,
            "pixels": self.checked,
            "frames": list(self.frames),
            "strata": [
                {**vars(each), "error": dict(zip(self.bands, each.error, strict=False))}
                for each in self.strata
            ],
            "text": "; ".join(self.lines),
        }

    def attributes(self) -> dict[str, str | float | int]:
        """Global attributes of the cube."""
        plain = self.as_dict()
        return {
            "hcss_certificate": plain["text"],
            "hcss_accuracy_achieved": json.dumps(plain["achieved"]),
            "hcss_certificate_pixels": self.checked,
            "hcss_certificate_strata": json.dumps(plain["strata"]),
        }

    @property
    def _verdict(self) -> str:
        if not self.checked:
            return "NOTHING CHECKED: no pixel of the drawn frames can be computed on the reference path"
        if self.passed:
            return f"PASSED: {self.checked} random pixels computed again without tables keep the accuracy asked for"
        worst = ", ".join(
            f"{each.name} ({each.exceeding} of {each.checked}, error up to {max(each.error):.{_DIGITS}g} in "
            f"{self.bands[int(np.argmax(each.error))]})"
            for each in self.strata
            if each.exceeding
        )
        return (
            f"FAILED: {self.exceeding} of {self.checked} random pixels computed again without tables err by more than "
            f"the accuracy asked for: {worst}"
        )

    @property
    def _left_out(self) -> tuple[str, ...]:
        told = [
            f"{count} {each.name} pixels {reason}"
            for each in self.strata
            for reason, count in each.left_out.items()
            if count
        ]
        return (f"left out, as the reference cannot follow them: {', '.join(told)}",) if told else ()

    @property
    def _confidence(self) -> tuple[str, ...]:
        if not self.checked or not self.passed:
            return ()
        alike, everywhere = (_percent(share) for share in (share_drawn_alike(self.checked), self.open_share))
        return (
            f"at {100 * CONFIDENCE:g} % confidence less than {alike} of pixels drawn alike, some of each kind, exceed "
            f"it (1 - 0.05^(1/{self.checked})), and at most {everywhere} of all pixels of which these were drawn",
        )


def certify(plan: Plan, tables: RadianceTables, frames: Sequence[SampledPixels]) -> Certificate:
    """Compute drawn pixels again on the reference path and compare.

    Parameters
    ----------
    frames : sequence of SampledPixels
        Of the run of this plan.

    Raises
    ------
    ProviderError
        If a provider breaks its contract.
    """
    names, bands = stratum_names(len(plan.layers)), len(plan.bands)
    checks = [_errors(plan, pixels) for pixels in frames]
    error = np.concatenate([np.empty((0, bands)), *(error for error, _ in checks)])
    exceeding = np.concatenate([np.empty(0, np.bool_), *(exceeding for _, exceeding in checks)])
    stratum = np.concatenate([np.empty(0, np.int64), *(pixels.stratum for pixels in frames)])
    size = np.array([pixels.pixels for pixels in frames]).reshape(len(frames), len(names))
    checked = np.array([np.bincount(pixels.stratum, minlength=len(names)) for pixels in frames])
    found = []
    for number, name in enumerate(names):
        own = stratum == number
        left_out = {
            "in the shadow of clouds": sum(int(pixels.in_shadow[number]) for pixels in frames),
            "with drawn waves": sum(int(pixels.with_waves[number]) for pixels in frames),
        }
        pixels_of = int(np.sum(size[:, number]))
        if pixels_of or any(left_out.values()):
            worst = tuple(_rounded(each) for each in np.max(error[own], axis=0)) if np.any(own) else ()
            found.append(
                StratumCheck(name, pixels_of, int(np.sum(own)), int(np.sum(exceeding[own])), worst, left_out)
            )
    return Certificate(
        requested=plan.scenario.accuracy,
        estimated=tables.estimated_error,
        bands=tuple(band.name for band in plan.bands),
        strata=tuple(found),
        frames=tuple(pixels.frame for pixels in frames),
        open_share=share_of_all(size.ravel(), checked.reshape(size.shape).ravel()),
    )


def _errors(plan: Plan, pixels: SampledPixels) -> tuple[Array, NDArray[np.bool_]]:
    """Relative errors (M, B), and which pixels err by more than is allowed in some band, (M,)."""
    count, layers, points = pixels.thickness_m.shape
    thickness = np.moveaxis(pixels.thickness_m, 1, 2).reshape(count * points, layers).astype(np.float64)
    for own, layer in zip(thickness.T, plan.layers, strict=True):
        # What single precision puts beyond the limits is taken for them, as in the look-up.
        np.clip(own, layer.thickness_min_m, layer.thickness_max_m, out=own, where=own > 0)
    columns, places = np.unique(thickness, axis=0, return_inverse=True)
    sun = plan.sun_up_at(pixels.time_s)
    known = reference_radiance(plan.model, plan.spectral_grid, columns, sun, COLUMNS_AT_ONCE)
    exact = np.mean(known[places.ravel()].reshape(count, points, len(plan.bands)), axis=1)
    away = np.abs(pixels.radiance.astype(np.float64) - exact)
    # The cube is in single precision: one step of its numbers is no error of the engine.
    rounding = np.spacing(np.abs(exact).astype(np.float32)).astype(np.float64)
    exceeding = np.any(away > plan.scenario.accuracy * np.abs(exact) + rounding, axis=1)
    error = np.divide(away, np.abs(exact), out=np.where(away > 0, np.inf, 0.0), where=exact != 0)
    return error, exceeding


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"
